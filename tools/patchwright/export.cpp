#include "output.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/normal_control.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct ExportOptions {
    CommonOptions common;
    OutputOptions output;
    std::string cage;
    std::string cage_unit = "mm";
    std::string tolerance = "1e-4rel";
};

int export_cage(const ExportOptions& options) {
    const auto cage_unit = base::parse_length_unit(options.cage_unit);
    if (options.output.colour == "deviation") {
        throw base::InvalidArgument(
            "--color deviation needs an input to deviate from; use convert, or --color kind");
    }
    const base::Length tolerance = base::parse_length(options.tolerance);
    Run run(options.common);
    run.report.unit =
        options.output.unit == "input" ? cage_unit : base::parse_length_unit(options.output.unit);
    const mesh::Cage cage = read_cage(run, options.cage, cage_unit);
    run.end_stage("read");
    write_patches(run, subd::control_normals(cage), options.output, run.report.unit,
                  tolerance.in_millimetres(geom::bounding_box(cage.points).diagonal()));
    run.end_stage("check");
    run.finish();
    return Done;
}

}  // namespace

void register_export(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<ExportOptions>();
    CLI::App* command = app.add_subcommand("export", "limit surface of a cage to a CAD file");
    command->add_option("cage", options->cage, "control mesh (OBJ)")->required();
    command->add_option("--cage-unit", options->cage_unit, "unit of the cage's numbers")
        ->capture_default_str();
    command
        ->add_option("--tolerance", options->tolerance,
                     "largest distance from the limit surface, which is exact away from "
                     "extraordinary vertices: 0.05mm, 0.002in, or 1e-4rel (of the diagonal)")
        ->capture_default_str();
    add_output_options(*command, options->output);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = export_cage(*options); });
}

}  // namespace patchwright::cli
