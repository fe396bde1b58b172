#include "command.h"
#include "options.h"
#include "places.h"
#include "surface.h"
#include "table.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/morph.h>
#include <patchwright/occ/assemble.h>

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
    std::string cage, displacements, output, cad_out, velocities_out, forces, forces_out;
    std::string cage_unit = "mm", tolerance = "1e-4rel";
};

/// A structural model's points, displacements and, where there are nine columns, velocities.
Table read_displacements(const MorphOptions& options) {
    Table table = read_table(options.displacements, 6, 9);
    if (table.columns != 6 && table.columns != 9)
        throw base::InputError(
            fmt::format("{}has {} numbers; 6 or 9 are expected: x, y, z, dx, dy, "
                        "dz, and perhaps vx, vy, vz",
                        table.place(0), table.columns));
    if (table.columns == 6 && !options.velocities_out.empty())
        throw base::InputError(
            fmt::format("{}has no velocities for --velocities-out; add vx, vy, "
                        "vz as the columns 7 to 9",
                        table.place(0)));
    for (std::size_t i = 0; i < table.rows(); ++i)
        for (std::size_t k = 0; k < table.columns; ++k)
            if (!(std::abs(table.row(i)[k]) <= geom::largest_coordinate))
                throw base::InputError(fmt::format("{}'{}' is above {:g}", table.place(i),
                                                   table.row(i)[k], geom::largest_coordinate));
    return table;
}

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

/// Adds the files of velocities and forces to the run's outputs.
void carry_values(Run& run, const MorphOptions& options, const mesh::Cage& cage,
                  const mesh::Cage& moved, const Table& table, const fit::PointTransfer& transfer) {
    const double unit = base::millimetres_per(run.report.unit);
    if (!options.velocities_out.empty())
        run.outputs.add(options.velocities_out, csv("x,y,z,vx,vy,vz", moved.points / unit,
                                                    transfer.apply(table.points(6))));
    if (options.forces.empty()) return;
    const SurfaceForces given(options.forces, *cage.topology);
    const Points carried = transfer.apply_transposed(
        fit::control_point_forces(cage.topology, given.places.locations(), given.forces));
    const Points points = table.points(0);
    run.outputs.add(options.forces_out, csv("x,y,z,fx,fy,fz", points, carried));
    run.report.morph->forces = compare(cage, given, points * unit, carried);
}

int morph_cage(const MorphOptions& options) {
    if (options.forces.empty() != options.forces_out.empty())
        throw base::UsageError("--forces and --forces-out go together");
    Run run(options.common, {{options.cage, options.displacements, options.forces},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--cad-out", options.cad_out, OutputKind::Cad},
                              {"--velocities-out", options.velocities_out, OutputKind::Table},
                              {"--forces-out", options.forces_out, OutputKind::Table}}});
    run.report.unit = base::parse_length_unit(options.cage_unit);
    const double unit = base::millimetres_per(run.report.unit);
    const mesh::Cage cage =
        about_input(options.cage, [&] { return read_cage(run, options.cage, run.report.unit); });
    if (!(options.velocities_out + options.forces).empty())
        refuse_sectors(options.cage, *cage.topology,
                       options.forces.empty() ? "--velocities-out" : "--forces");
    const Table table = read_displacements(options);
    run.end_stage("read");
    const Points displacements = table.points(3) * unit;
    const auto transfer = about_input(options.displacements, [&] {
        return fit::PointTransfer(table.points(0) * unit, cage.points, [&](int i) {
            return fmt::format("line {}", table.lines[std::size_t(i)]);
        });
    });
    note_extrapolation(run, options.displacements, transfer.extrapolation());
    const mesh::Cage moved =
        about_input(options.cage, [&] { return fit::morph(cage, transfer, displacements); });
    if (!(moved.points.cwiseAbs().maxCoeff() <= geom::largest_coordinate))
        throw base::InputError(fmt::format("{}: moves control points beyond {:g}",
                                           options.displacements, geom::largest_coordinate));
    run.report.morph = {int(table.rows()),
                        displacements.rowwise().norm().maxCoeff(),
                        (moved.points - cage.points).rowwise().norm().maxCoeff(),
                        transfer.extrapolation(),
                        {}};
    carry_values(run, options, cage, moved, table, transfer);
    run.end_stage("transfer");
    if (!options.cad_out.empty()) {
        const geom::Box3 box = geom::bounding_box(moved.points);
        occ::check_size(box, options.displacements);
        convert::ShapeOptions making;
        making.write.unit = run.report.unit;
        write_surface(run, moved, options.cad_out, making,
                      length_mm(options.tolerance, box.diagonal()));
    }
    write_cage(run, moved, options.output, run.report.unit);
    run.end_stage("write");
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
                     "cage's unit")
        ->required();
    command->add_option("-o,--output", options->output, "displaced control mesh (OBJ)")->required();
    command->add_option("--cad-out", options->cad_out,
                        "write the displaced limit surface, and check it as export does: .step "
                        ".stp .igs .iges .brep");
    command->add_option("--velocities-out", options->velocities_out,
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
    command
        ->add_option("--tolerance", options->tolerance,
                     fmt::format("of --cad-out: largest distance from the limit surface, which is "
                                 "exact away from extraordinary vertices: {}",
                                 length_help))
        ->check(is_length())
        ->capture_default_str();
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = morph_cage(*options); });
}

}  // namespace patchwright::cli
