#include "options.h"

#include <patchwright/base/error.h>
#include <patchwright/convert/figures.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

struct FitCommandOptions {
    CommonOptions common;
    FitArguments fit;
    CageArguments cage;
    InputOptions read;
    std::string input, cage_file, output, normal_tolerance;
    bool interpolate = false;
};

/// @throw UsageError for what says how a fit by least squares goes
void check_interpolation(const FitCommandOptions& options) {
    if (!options.interpolate) return;
    for (const char* option : {"--max-levels", "--refine", "--symmetry", "--crease-rule"})
        if (options.common.command->count(option) > 0)
            throw base::UsageError(
                fmt::format("--interpolate and {} do not go together: the cage is not refined, and "
                            "no plane is kept",
                            option));
}

int fit_file(const FitCommandOptions& options) {
    Run run(options.common,
            {{options.input, options.cage_file}, {{"--output", options.output, OutputKind::Cage}}});
    check_interpolation(options);
    const base::Budget budget = run.budget(options.fit.time_limit_s);
    convert::Source source =
        read_source(run, options.input, options.read, {.progress = budget.limited()});
    refuse_control_mesh(source);
    convert::ConvertOptions fitting =
        convert_options(run, source, options.fit, options.cage, options.cage_file);
    if (!fitting.cage) leave_out_narrow_holes(run, source, fitting.tolerance_mm);
    fitting.interpolate = options.interpolate;
    fitting.normal_tolerance_rad = normal_tolerance_rad(options.normal_tolerance);
    convert::Conversion fitted = about_input(
        options.interpolate && !options.cage_file.empty() ? options.cage_file : options.input,
        [&] { return convert::fit_only(source, fitting, budget); });
    for (const auto& [stage, seconds] : fitted.seconds) run.add_stage(stage, seconds);
    for (const std::string& text : fitted.notices) run.notice(text);
    const convert::Attempt& attempt = fitted.attempts.front();
    convert::add_fitted(run.report, attempt);
    write_cage(run, attempt.fitted, options.output, base::parse_length_unit(options.fit.cage_unit));
    run.end_stage("write");
    return run.finish();
}

}  // namespace

void register_fit(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<FitCommandOptions>();
    CLI::App* command =
        app.add_subcommand("fit", "fit a cage to a CAD file, write the fitted cage");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("--cage", options->cage_file,
                        "control mesh (OBJ); by default it is made from the CAD");
    command->add_option("-o,--output", options->output, "fitted control mesh (OBJ)")->required();
    command->add_flag(
        "--interpolate", options->interpolate,
        "put the limit points of all vertices on the model, in place of least squares "
        "over many samples and refinement");
    add_input_options(*command, options->read);
    add_foot_point_option(*command, options->read);
    add_cage_options(*command, options->cage);
    add_fit_options(*command, options->fit);
    add_normal_tolerance_option(*command, options->normal_tolerance);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->input, [&] { return fit_file(*options); });
    });
}

}  // namespace patchwright::cli
