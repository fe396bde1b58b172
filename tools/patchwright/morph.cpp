#include "blocks.h"
#include "command.h"
#include "options.h"
#include "places.h"
#include "steps.h"
#include "surface.h"
#include "table.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/morph.h>
#include <patchwright/grid/write.h>
#include <patchwright/measure/verdict.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <memory>

namespace patchwright::cli {

namespace {

using geom::Points;
using geom::Vec3;

/// PointTransfer::extrapolation beyond which errors of displacements show: digits are lost.
constexpr double much_extrapolation = 10.0;

struct MorphOptions {
    CommonOptions common;
    BlockArguments blocks;
    std::string cage;
    std::vector<std::string> displacements;  ///< a file a step
    StepOutputs outputs;
    std::string forces, forces_out;
    std::string cage_unit = "mm", tolerance = "1e-4rel";
};

/// One line a point: its place, its value.
std::string csv(const std::string& head, const Points& points, const Points& values) {
    std::string text = head + "\n";
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{}\n", points(i, 0), points(i, 1),
                       points(i, 2), values(i, 0), values(i, 1), values(i, 2));
    return text;
}

/// Forces at places of the limit surface.
struct SurfaceForces {
    Places places;
    Points forces;

    SurfaceForces(const std::string& file, const mesh::Topology& topology) {
        const Table table = read_table(file, 6, 7);
        const bool has_sector = table.columns == 7;
        for (std::size_t i = 0; i < table.rows(); ++i) places.add(table, i, has_sector, topology);
        forces = table.points(table.columns - 3);
    }
};

double sum_of_sizes(const Points& forces) { return forces.rowwise().norm().sum(); }

/// What sum and moment lose on their way.
/// @param points  of the structural model, in millimetres
report::MorphFigures::Forces compare(const mesh::Cage& cage, const SurfaceForces& given,
                                     const Points& points, const Points& carried) {
    const Points at =
        subd::LimitEvaluator(cage.topology).evaluate(cage.points, given.places.locations());
    const fit::Resultant before = fit::resultant(at, given.forces, Vec3::Zero());
    const fit::Resultant after = fit::resultant(points, carried, Vec3::Zero());
    const double size = sum_of_sizes(given.forces),
                 moments = at.rowwise().norm().dot(given.forces.rowwise().norm());
    const auto share = [](double error, double of) { return of > 0.0 ? error / of : error; };
    return {int(at.rows()), before, share((after.force - before.force).norm(), size),
            share((after.moment - before.moment).norm(), moments)};
}

void note_extrapolation(Run& run, const std::string& file, double extrapolation) {
    if (extrapolation <= much_extrapolation) return;
    run.notice(
        fmt::format("{}: control points are {:.3g} times as far from the middle of the "
                    "points as these are on average: displacements there are "
                    "extrapolated; add points around the cage, in its unit",
                    file, extrapolation));
}

/// Carries the forces to the points of the structural model, undisplaced as the cage.
void carry_forces(Run& run, const MorphOptions& options, const mesh::Cage& cage,
                  const Points& points, const fit::PointTransfer& transfer) {
    if (options.forces.empty()) return;
    const SurfaceForces given(options.forces, *cage.topology);
    const Points carried = transfer.apply_transposed(
        fit::control_point_forces(cage.topology, given.places.locations(), given.forces));
    run.outputs.add(options.forces_out, csv("x,y,z,fx,fy,fz", points, carried));
    run.report.morph->forces =
        compare(cage, given, points * base::millimetres_per(run.report.unit), carried);
}

/// The cage at rest, what carries it along and what is written of all steps alike.
struct Motion {
    Run& run;
    const MorphOptions& options;
    mesh::Cage cage;
    fit::PointTransfer transfer;
    std::optional<grid::Plan> plan;  ///< where grids are written
};

mesh::Cage displaced(const Motion& motion, const Table& table,
                     report::MorphFigures::Step& figures) {
    const Points displacements = table.points(3) * base::millimetres_per(motion.run.report.unit);
    mesh::Cage moved = about_input(motion.options.cage, [&] {
        return fit::morph(motion.cage, motion.transfer, displacements);
    });
    if (!(moved.points.cwiseAbs().maxCoeff() <= geom::largest_coordinate))
        throw base::InputError(fmt::format("{}: moves control points beyond {:g}", table.file,
                                           geom::largest_coordinate));
    figures = {.file = table.file,
               .largest_displacement = displacements.rowwise().norm().maxCoeff(),
               .largest_moved = (moved.points - motion.cage.points).rowwise().norm().maxCoeff()};
    return moved;
}

/// The grid at rest with its points carried along, and their velocities where there are some.
measure::Failures write_step_grid(const Motion& motion, const std::string& file,
                                  const mesh::Cage& moved,
                                  const std::optional<Points>& velocities) {
    Run& run = motion.run;
    const grid::Plan plan = grid::with_points(*motion.plan, subd::control_normals(moved).points);
    std::optional<grid::Plan> velocity;
    if (velocities) velocity = grid::with_points(*motion.plan, *velocities);
    const grid::GridQuality quality =
        grid::write_grid(grid::SurfaceGrid(plan), file, run.outputs,
                         {.unit = run.report.unit,
                          .velocities = velocity ? &*velocity : nullptr,
                          .progress = run.progress()});
    run.report.grid = report::GridFigures{file, quality};
    const measure::Failures bad{int(quality.folded + quality.negative), {}};
    run.report.verdict = measure::assess({.bad_grid_cells = bad, .is_grid = true});
    run.end_stage("grid");
    return bad;
}

/// Leaves the step's figures in the report's sections as well.
report::MorphFigures::Step carry_step(const Motion& motion, const StepFiles& files,
                                      const Table& table) {
    Run& run = motion.run;
    const double unit = base::millimetres_per(run.report.unit);
    report::MorphFigures::Step figures;
    const mesh::Cage moved = displaced(motion, table, figures);
    std::optional<Points> velocities;
    if (table.columns == 9 && !(files.outputs.velocities + files.outputs.grid).empty())
        velocities = motion.transfer.apply(table.points(6) * unit);
    if (!files.outputs.velocities.empty())
        run.outputs.add(files.outputs.velocities,
                        csv("x,y,z,vx,vy,vz", moved.points / unit, *velocities / unit));
    run.end_stage("transfer");
    std::optional<measure::Failures> bad_grid_cells;
    if (!files.outputs.grid.empty())
        bad_grid_cells = write_step_grid(motion, files.outputs.grid, moved, velocities);
    if (!files.outputs.cad.empty())
        write_moved_surface(run, moved,
                            {.file = files.outputs.cad,
                             .tolerance = motion.options.tolerance,
                             .cause = files.displacements,
                             .bad_grid_cells = bad_grid_cells});
    write_cage(run, moved, files.outputs.cage, run.report.unit);
    run.end_stage("write");
    figures.verdict = run.report.verdict;
    figures.solid = run.report.solid;
    figures.grid = run.report.grid;
    return figures;
}

/// All steps; the report's sections are those of the first one that is missed, or of the last.
void carry_steps(const Motion& motion, const std::vector<StepFiles>& files,
                 const std::vector<Table>& tables) {
    report::RunReport& report = motion.run.report;
    std::optional<report::RunReport> missed;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const report::MorphFigures::Step step = carry_step(motion, files[i], tables[i]);
        report.morph->steps.push_back(step);
        if (!step.verdict || step.verdict->met()) continue;
        if (files.size() > 1)
            motion.run.notice(
                fmt::format("{}: {}", step.file, step.verdict->sentence(report.unit)));
        if (!missed) missed = report;
    }
    if (!missed) return;
    report.verdict = missed->verdict;
    report.patches = missed->patches;
    report.solid = missed->solid;
    report.continuity = missed->continuity;
    report.grid = missed->grid;
}

/// Where velocities of the surface or forces are asked for, masks must be all that it depends on.
void check_sectors(const MorphOptions& options, const mesh::Topology& topology, bool velocities) {
    const char* what = !options.forces.empty()                       ? "--forces"
                       : !options.outputs.velocities.empty()         ? "--velocities-out"
                       : velocities && !options.outputs.grid.empty() ? "--grid-out with velocities"
                                                                     : nullptr;
    if (what != nullptr) refuse_sectors(options.cage, topology, what);
}

RunFiles run_files(const MorphOptions& options, const std::vector<StepFiles>& steps) {
    RunFiles files{{options.cage, options.forces}, {}};
    add_files(files, steps);
    files.outputs.push_back({"--forces-out", options.forces_out, OutputKind::Table});
    return files;
}

int morph_cage(const MorphOptions& options) {
    if (options.forces.empty() != options.forces_out.empty())
        throw base::UsageError("--forces and --forces-out go together");
    if (options.displacements.size() > 1 &&
        options.forces_out.find(step_placeholder) != std::string::npos)
        throw base::UsageError(
            fmt::format("{}: --forces-out writes one file, as forces are carried alike at all "
                        "steps; leave {} out of its name",
                        options.forces_out, step_placeholder));
    const std::vector<StepFiles> files = step_files(options.displacements, options.outputs);
    Run run(options.common, run_files(options, files));
    run.report.unit = base::parse_length_unit(options.cage_unit);
    const double unit = base::millimetres_per(run.report.unit);
    const mesh::Cage cage =
        about_input(options.cage, [&] { return read_cage(run, options.cage, run.report.unit); });
    const std::vector<Table> tables = read_steps(files);
    const Table& first = tables.front();
    check_sectors(options, *cage.topology, first.columns == 9);
    run.end_stage("read");
    const Points points = first.points(0);
    const auto transfer = about_input(first.file, [&] {
        return fit::PointTransfer(points * unit, cage.points, [&](int i) {
            return fmt::format("line {}", first.lines[std::size_t(i)]);
        });
    });
    note_extrapolation(run, first.file, transfer.extrapolation());
    run.report.morph = {
        .points = int(first.rows()), .extrapolation = transfer.extrapolation(), .steps = {}};
    carry_forces(run, options, cage, points, transfer);
    run.end_stage("transfer");
    Motion motion{run, options, cage, transfer, std::nullopt};
    if (!options.outputs.grid.empty()) {
        const double diagonal = geom::bounding_box(cage.points).diagonal();
        motion.plan = about_input(options.cage, [&] {
            return grid::make_plan(make_layout(subd::control_normals(cage), options.blocks),
                                   plan_options(options.blocks, diagonal));
        });
        run.end_stage("plan");
    }
    carry_steps(motion, files, tables);
    return run.finish();
}

}  // namespace

void register_morph(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<MorphOptions>();
    CLI::App* command = app.add_subcommand(
        "morph", "carry a cage along with displaced points, and forces back to them");
    command->add_option("cage", options->cage, "control mesh (OBJ)")->required();
    command
        ->add_option("--displacements", options->displacements,
                     "points of a structural model that are not all in one plane, a line each: "
                     "x,y,z,dx,dy,dz, or with velocities x,y,z,dx,dy,dz,vx,vy,vz; lengths in the "
                     "cage's unit. Several files of the same points are the steps of a motion: "
                     "{step} in names of outputs stands for each file's name without extension")
        ->required()
        ->check(is_not_empty());
    command->add_option("-o,--output", options->outputs.cage, "displaced control mesh (OBJ)")
        ->required();
    command->add_option("--cad-out", options->outputs.cad,
                        "write the displaced limit surface, and check it as export does: .step "
                        ".stp .igs .iges .brep");
    command->add_option("--grid-out", options->outputs.grid,
                        "write a grid of the displaced limit surface whose points stay where they "
                        "are on it: .cgns, .vtm, with exact velocities where the displacements "
                        "have some; or .xyz, .p3d");
    add_block_options(*command, options->blocks);
    command->add_option("--velocities-out", options->outputs.velocities,
                        "write velocities of the control points: x,y,z,vx,vy,vz; those of the "
                        "surface are its limit points with these in place of the control points");
    command->add_option("--forces", options->forces,
                        "forces at places of the surface, a line each: FACE,U,V,FX,FY,FZ, or "
                        "FACE,U,V,SECTOR,FX,FY,FZ; places as of eval --at-file");
    command->add_option("--forces-out", options->forces_out,
                        "write the forces at the points of the structural model that do the same "
                        "work: x,y,z,fx,fy,fz; their sum and moment stay");
    command->add_option("--cage-unit", options->cage_unit, "unit of the cage's and points' numbers")
        ->check(is_unit())
        ->capture_default_str();
    add_surface_tolerance(*command, options->tolerance);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = morph_cage(*options); });
}

}  // namespace patchwright::cli
