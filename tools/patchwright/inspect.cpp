#include "options.h"
#include "view.h"

#include <patchwright/convert/figures.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct InspectOptions {
    CommonOptions common;
    InputOptions read;
    ViewArguments view;
    std::string file;
    bool no_heal = false;
};

int inspect(const InspectOptions& options) {
    Run run(options.common, {{options.file}, view_files(options.view)});
    const convert::Source input =
        read_source(run, options.file, options.read,
                    {.heal = !options.no_heal, .with_surface = shows_anything(run, options.view)});
    run.report.solid = input.figures;
    run.report.details = convert::inspect_closely(input, run.progress());
    run.end_stage("check");
    if (shows_anything(run, options.view))
        add_views(run, options.view, {.output = &input.surface()});
    return run.finish();
}

}  // namespace

void register_inspect(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<InspectOptions>();
    CLI::App* command =
        app.add_subcommand("inspect", "what is in a CAD file, after reading and sewing");
    command->add_option("file", options->file, input_help)->required();
    add_input_options(*command, options->read);
    command->add_flag("--no-heal", options->no_heal,
                      "CAD: as it is in the file, nothing sewn or turned");
    add_view_options(*command, options->view, false);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->file, [&] { return inspect(*options); });
    });
}

}  // namespace patchwright::cli
