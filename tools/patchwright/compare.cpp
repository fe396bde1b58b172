#include "input.h"
#include "output.h"

#include <memory>

namespace patchwright::cli {

namespace {

struct CompareOptions {
    CommonOptions common;
    InputOptions read;
    std::string a, b, tolerance;
    int samples = 20000;
};

int compare(const CompareOptions& options) {
    if (!options.tolerance.empty()) base::parse_length(options.tolerance);
    Run run(options.common);
    Input b = read_input(run, options.b, {.sharp_angle_deg = options.read.sharp_angle_deg});
    Input a = read_input(run, options.a, options.read);
    run.report.solid = b.figures;
    prepare(run, a);
    prepare(run, b);
    const geom::ModelSurface &input = a.reference(), &output = b.reference();
    std::optional<double> tolerance;
    if (!options.tolerance.empty())
        tolerance = base::parse_length(options.tolerance).in_millimetres(input.bounds().diagonal());
    compare_models(run, output, input, options.samples, tolerance);
    run.end_stage("check");
    run.finish();
    return Done;
}

}  // namespace

void register_compare(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command = app.add_subcommand(
        "compare", "two-sided deviation of two CAD files; A counts as input, B as output");
    command->add_option("a", options->a, input_help)->required();
    command->add_option("b", options->b, input_help)->required();
    command->add_option("--samples", options->samples, "samples each way")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--tolerance", options->tolerance,
                        "look one by one at A's sharp curves that are longer than 100 times this: "
                        "0.05mm, 0.002in, or 1e-4rel (of A's diagonal)");
    add_input_options(*command, options->read);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = compare(*options); });
}

}  // namespace patchwright::cli
