#include "checks.h"
#include "command.h"
#include "surface.h"
#include "table.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/modes.h>

#include <fmt/format.h>

#include <cmath>
#include <memory>

namespace patchwright::cli {

namespace {

constexpr std::size_t most_columns = 3 * 1001;

struct MemberOptions {
    CommonOptions common;
    std::string cage, modes, output, cad_out;
    std::vector<double> weights;
    std::string cage_unit = "mm", tolerance = "1e-4rel";
};

/// Mean and modes as `family --modes-out` writes them, in millimetres.
fit::Modes read_modes(const std::string& file, const mesh::Cage& cage, double unit) {
    const Table table = read_table(file, 6, most_columns);
    if (table.columns % 3 != 0)
        throw base::InputError(
            fmt::format("{}has {} numbers; three of the mean and three of each mode are expected",
                        table.place(0), table.columns));
    if (table.rows() != std::size_t(cage.topology->vertex_count()))
        throw base::InputError(
            fmt::format("{}: has {} rows, and the cage {} control points; it is of another cage",
                        file, table.rows(), cage.topology->vertex_count()));
    fit::Modes modes{.mean = table.points(0) * unit};
    for (std::size_t column = 3; column < table.columns; column += 3)
        modes.shapes.push_back(table.points(column));
    return modes;
}

int make_member(const MemberOptions& options) {
    Run run(options.common, {{options.cage, options.modes},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--cad-out", options.cad_out, OutputKind::Cad}}});
    run.report.unit = base::parse_length_unit(options.cage_unit);
    const double unit = base::millimetres_per(run.report.unit);
    mesh::Cage cage =
        about_input(options.cage, [&] { return read_cage(run, options.cage, run.report.unit); });
    const fit::Modes modes = read_modes(options.modes, cage, unit);
    if (options.weights.size() > std::size_t(modes.count()))
        throw base::UsageError(fmt::format("--weights: {} are given, and {} has {} modes",
                                           options.weights.size(), options.modes, modes.count()));
    run.end_stage("read");
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(modes.count());
    for (std::size_t k = 0; k < options.weights.size(); ++k)
        weights[Eigen::Index(k)] = options.weights[k] * unit;
    cage.points = fit::member(modes, weights);
    if (!(cage.points.cwiseAbs().maxCoeff() <= geom::largest_coordinate))
        throw base::UsageError(fmt::format("--weights: they move control points beyond {:g}",
                                           geom::largest_coordinate));
    if (!options.cad_out.empty())
        write_moved_surface(
            run, cage,
            {.file = options.cad_out, .tolerance = options.tolerance, .cause = options.modes});
    write_cage(run, cage, options.output, run.report.unit);
    run.end_stage("write");
    return run.finish();
}

}  // namespace

void register_member(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<MemberOptions>();
    CLI::App* command =
        app.add_subcommand("member", "a member of a family of designs by the weights of its modes");
    command->add_option("cage", options->cage, "control mesh of any member (OBJ)")->required();
    command->add_option("--modes", options->modes, "mean and modes, as family --modes-out writes")
        ->required();
    command
        ->add_option("--weights", options->weights,
                     "of the modes, the first ones: root mean square displacements of the surface "
                     "from the mean, in the cage's unit; without it the mean")
        ->delimiter(',');
    command->add_option("-o,--output", options->output, "control mesh of the member (OBJ)")
        ->required();
    command->add_option("--cad-out", options->cad_out,
                        "write the member's limit surface, and check it as export does: .step "
                        ".stp .igs .iges .brep");
    command->add_option("--cage-unit", options->cage_unit, "unit of the cage's and modes' numbers")
        ->check(is_unit())
        ->capture_default_str();
    add_surface_tolerance(*command, options->tolerance);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = make_member(*options); });
}

}  // namespace patchwright::cli
