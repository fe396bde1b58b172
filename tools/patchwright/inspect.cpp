#include "command.h"

#include <memory>

namespace patchwright::cli {

namespace {

struct InspectOptions {
    CommonOptions common;
    std::string file, input_unit;
    bool no_heal = false;
};

int inspect(const InspectOptions& options) {
    Run run(options.common);
    run.report.solid = read_input(run, options.file, options.input_unit, !options.no_heal).figures;
    run.end_stage("check");
    run.finish();
    return Done;
}

}  // namespace

void register_inspect(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<InspectOptions>();
    CLI::App* command =
        app.add_subcommand("inspect", "what is in a CAD file, after reading and sewing");
    command->add_option("file", options->file, "CAD file: STEP, IGES or BREP")->required();
    command->add_option("--input-unit", options->input_unit,
                        "overrides the unit written in the file");
    command->add_flag("--no-heal", options->no_heal,
                      "as it is in the file: nothing sewn or turned");
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = inspect(*options); });
}

}  // namespace patchwright::cli
