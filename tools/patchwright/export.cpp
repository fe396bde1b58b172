#include "options.h"
#include "surface.h"
#include "view.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/assemble.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct ExportOptions {
    CommonOptions common;
    OutputOptions output;
    ViewArguments view;
    std::string cage;
    std::string cage_unit = "mm";
    std::string tolerance = "1e-4rel";
};

int export_cage(const ExportOptions& options) {
    const auto cage_unit = base::parse_length_unit(options.cage_unit);
    if (options.output.shape.colouring == convert::Colouring::Deviation) {
        throw base::UsageError(
            "--color deviation needs an input to deviate from; use convert, or --color kind");
    }
    RunFiles files{{options.cage}, {{"--output", options.output.file, OutputKind::Cad}}};
    for (const OutputFile& file : view_files(options.view)) files.outputs.push_back(file);
    Run run(options.common, files);
    run.report.unit = output_unit(options.output, cage_unit);
    const mesh::Cage cage = read_cage(run, options.cage, cage_unit);
    occ::check_size(geom::bounding_box(cage.points), options.cage);
    run.end_stage("read");
    convert::ShapeOptions making = options.output.shape;
    making.write.unit = run.report.unit;
    const double tolerance =
        length_mm(options.tolerance, geom::bounding_box(cage.points).diagonal());
    const occ::CadModel written = about_input(options.cage, [&] {
        return write_surface(run, cage, options.output.file, making, tolerance);
    });
    if (shows_anything(run, options.view)) {
        const occ::CadReference surface(written);
        add_views(run, options.view, {.output = &surface, .cage = &cage});
    }
    return run.finish();
}

}  // namespace

void register_export(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<ExportOptions>();
    CLI::App* command = app.add_subcommand("export", "limit surface of a cage to a CAD file");
    command->add_option("cage", options->cage, "control mesh (OBJ)")->required();
    command->add_option("--cage-unit", options->cage_unit, "unit of the cage's numbers")
        ->check(is_unit())
        ->capture_default_str();
    command
        ->add_option("--tolerance", options->tolerance,
                     fmt::format("largest distance from the limit surface, which is exact away "
                                 "from extraordinary vertices: {}",
                                 length_help))
        ->check(is_length())
        ->capture_default_str();
    add_output_options(*command, options->output);
    add_view_options(*command, options->view, false);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->cage, [&] { return export_cage(*options); });
    });
}

}  // namespace patchwright::cli
