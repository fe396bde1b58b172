#include "options.h"
#include "view.h"

#include <patchwright/convert/figures.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct CompareOptions {
    CommonOptions common;
    InputOptions read;
    std::string a, b, tolerance, normal_tolerance;
    ViewArguments view;
    int samples = convert::ConvertOptions{}.samples;
};

int compare_files(const CompareOptions& options) {
    Run run(options.common, {{options.a, options.b}, view_files(options.view)});
    InputOptions output = options.read;
    output.unit.clear();  // given for A, as the input
    const convert::Source b = read_source(run, options.b, output);
    const convert::Source a = read_source(run, options.a, options.read);
    run.report.solid = b.figures;
    std::optional<double> tolerance;
    if (!options.tolerance.empty()) tolerance = length_mm(options.tolerance, a.input.diagonal);
    report::DeviationFigures deviation =
        convert::compare(b.surface(), a.surface(), options.samples, tolerance, run.progress());
    convert::add_bounds(deviation, b.surface(), a.surface(), run.progress());
    if (tolerance)
        run.report.verdict = convert::assess(b, a, deviation, *tolerance,
                                             normal_tolerance_rad(options.normal_tolerance));
    run.report.deviation = std::move(deviation);
    run.end_stage("check");
    add_views(run, options.view,
              {.output = &b.surface(), .input = &a.surface(), .scale_mm = tolerance});
    return run.finish();
}

}  // namespace

void register_compare(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command = app.add_subcommand(
        "compare", "two-sided deviation of two CAD files; A counts as input, B as output");
    command->add_option("a", options->a, input_help)->required();
    command->add_option("b", options->b, input_help)->required();
    command->add_option("--samples", options->samples, "samples each way")
        ->check(number_in(1, most_samples))
        ->capture_default_str();
    CLI::Option* tolerance =
        command
            ->add_option(
                "--tolerance", options->tolerance,
                fmt::format("largest deviation both ways, else the exit code is 3; A's sharp "
                            "curves that are longer than 100 times this have to be kept: {}",
                            length_help))
            ->check(is_length());
    add_normal_tolerance_option(*command, options->normal_tolerance)->needs(tolerance);
    add_view_options(*command, options->view, true);
    add_input_options(*command, options->read);
    add_foot_point_option(*command, options->read);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->a, [&] { return compare_files(*options); });
    });
}

}  // namespace patchwright::cli
