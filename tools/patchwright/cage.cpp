#include "options.h"
#include "view.h"

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct CageCommandOptions {
    CommonOptions common;
    CageArguments cage;
    InputOptions read;
    ViewArguments view{.layer = report::PictureLayer::Patches};
    std::string input, output;
    std::string tolerance = "1e-4rel", cage_unit = "mm";
};

int make_cage_file(const CageCommandOptions& options) {
    Run run(options.common, {{options.input},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--picture", options.view.picture, OutputKind::Picture}}});
    convert::Source source = read_source(run, options.input, options.read);
    refuse_control_mesh(source);
    const double diagonal = source.input.diagonal;
    const double tolerance = length_mm(options.tolerance, diagonal);
    leave_out_narrow_holes(run, source, tolerance);
    const cage::CageResult made =
        cage::make_cage(source.surface(), {.method = options.cage.method,
                                           .target_faces = options.cage.target_faces,
                                           .tolerance_rel = tolerance / diagonal,
                                           .progress = run.progress()});
    for (const std::string& text : made.notices) run.notice(text);
    run.report.cage = mesh::summarise(*made.cage.topology);
    run.report.layout = made.layout;
    run.end_stage("layout");
    write_cage(run, made.cage, options.output, base::parse_length_unit(options.cage_unit));
    run.end_stage("write");
    if (shows_anything(run, options.view))
        add_drawing(run, options.view, report::draw_mesh(made.cage), "The control mesh");
    return run.finish();
}

}  // namespace

void register_cage(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<CageCommandOptions>();
    CLI::App* command = app.add_subcommand("cage", "control mesh from a CAD file");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("-o,--output", options->output, "control mesh (OBJ)")->required();
    command
        ->add_option("--tolerance", options->tolerance,
                     fmt::format("what the cage is to be fitted to: {}", length_help))
        ->check(is_length())
        ->capture_default_str();
    command
        ->add_option("--cage-unit", options->cage_unit,
                     "unit of the cage's numbers: mm, cm, m, in, ft")
        ->check(is_unit())
        ->capture_default_str();
    add_input_options(*command, options->read);
    add_cage_options(*command, options->cage);
    add_picture_options(*command, options->view);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->input, [&] { return make_cage_file(*options); });
    });
}

}  // namespace patchwright::cli
