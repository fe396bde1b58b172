#include "options.h"

#include <patchwright/base/error.h>
#include <patchwright/convert/figures.h>

#include <fmt/format.h>

#include <memory>
#include <optional>

namespace patchwright::cli {

namespace {

struct RefitCommandOptions {
    CommonOptions common;
    FitArguments fit;
    InputOptions read;
    std::string cage_file, input, earlier, output, cad_out;
};

int refit_file(const RefitCommandOptions& options) {
    Run run(options.common, {{options.cage_file, options.input, options.earlier},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--cad-out", options.cad_out, OutputKind::Cad}}});
    const base::Budget budget = run.budget(options.fit.time_limit_s);
    std::optional<convert::Source> earlier;
    if (!options.earlier.empty())
        earlier = read_source(run, options.earlier, options.read, {.progress = budget.limited()});
    const convert::Source source =
        read_source(run, options.input, options.read, {.progress = budget.limited()});
    refuse_control_mesh(source);
    convert::ConvertOptions refitting =
        convert_options(run, source, options.fit, CageArguments(), options.cage_file);
    refitting.refit = true;
    refitting.earlier = earlier ? &*earlier : nullptr;
    refitting.shape.write.unit = run.report.unit;
    const convert::Conversion refitted =
        options.cad_out.empty()
            ? convert::fit_only(source, refitting, budget)
            : convert::convert(source, options.cad_out, run.outputs, refitting, budget);
    for (const auto& [stage, seconds] : refitted.seconds) run.add_stage(stage, seconds);
    for (const std::string& text : refitted.notices) run.notice(text);
    if (!refitted.kept) throw base::TimeLimitReached();
    const convert::Attempt& attempt = refitted.attempts[*refitted.kept];
    if (options.cad_out.empty())
        convert::add_fitted(run.report, attempt);
    else
        convert::add_attempt(run.report, attempt);
    write_cage(run, attempt.fitted, options.output, base::parse_length_unit(options.fit.cage_unit));
    run.end_stage("write");
    return run.finish();
}

}  // namespace

void register_refit(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<RefitCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "refit", "fit a fitted cage to a changed CAD file, with the same topology");
    command->add_option("cage", options->cage_file, "fitted control mesh (OBJ)")->required();
    command->add_option("input", options->input, input_help)->required();
    command->add_option(
        "--from", options->earlier,
        "what the cage was fitted to, with the same faces as the new model by name or order, as "
        "parametric CAD writes them: points go with these, however far; refused where faces do not "
        "correspond");
    command->add_option("-o,--output", options->output, "control mesh of the new shape (OBJ)")
        ->required();
    command->add_option("--cad-out", options->cad_out,
                        "write the new limit surface, and check it as convert does: .step .stp "
                        ".igs .iges .brep");
    add_input_options(*command, options->read);
    add_fit_options(*command, options->fit, false);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->input, [&] { return refit_file(*options); });
    });
}

}  // namespace patchwright::cli
