#include "fitting.h"

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct CageCommandOptions {
    CommonOptions common;
    LayoutOptions layout;
    InputOptions read;
    std::string input, output;
    FitCommandOptions fit;
};

int cage(const CageCommandOptions& options) {
    const auto cage_unit = base::parse_length_unit(options.fit.cage_unit);
    base::parse_length(options.fit.tolerance);
    Run run(options.common);
    Input input = read_input(run, options.input, options.read);
    prepare(run, input);
    const double tolerance = relative_tolerance(options.fit, input.reference());
    const auto made = make_cage(run, input, options.layout, tolerance);
    run.end_stage("layout");
    write_cage(made.cage, options.output, cage_unit);
    run.end_stage("write");
    run.finish();
    return Done;
}

}  // namespace

void register_cage(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<CageCommandOptions>();
    CLI::App* command = app.add_subcommand("cage", "control mesh from a CAD file");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("-o,--output", options->output, "control mesh (OBJ)")->required();
    command
        ->add_option("--tolerance", options->fit.tolerance,
                     "what the cage is to be fitted to: 0.05mm, 0.002in, or 1e-4rel (of the "
                     "diagonal)")
        ->capture_default_str();
    command
        ->add_option("--cage-unit", options->fit.cage_unit,
                     "unit of the cage's numbers: mm, cm, m, in, ft")
        ->capture_default_str();
    add_input_options(*command, options->read);
    add_layout_options(*command, options->layout);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = cage(*options); });
}

}  // namespace patchwright::cli
