#include "options.h"
#include "view.h"

#include <patchwright/base/error.h>
#include <patchwright/convert/figures.h>
#include <patchwright/occ/inspect_closely.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

/// A conversion that takes longer is worth a look at what it tries.
constexpr double time_limit_s = 60.0;

struct ConvertCommandOptions {
    CommonOptions common;
    OutputOptions output;
    FitArguments fit{.time_limit_s = time_limit_s};
    CageArguments cage;
    InputOptions read;
    std::string input, cage_file, cage_out, normal_tolerance;
    ViewArguments view;
    int samples = convert::ConvertOptions{}.samples;
};

/// What was tried where the first attempt was not the last.
/// @param of  goes before an attempt's number
void note_attempts(Run& run, const convert::Conversion& conversion, const std::string& of = "") {
    const auto& attempts = conversion.attempts;
    for (std::size_t i = 0; i < attempts.size() && attempts.size() > 1; ++i)
        run.notice(fmt::format(
            "{}attempt {} ({} faces{}): {}", of, i + 1, attempts[i].cage.topology->face_count(),
            i == conversion.kept ? ", kept" : "", attempts[i].verdict.sentence(run.report.unit)));
    for (std::size_t i = 0; i < conversion.bodies.size(); ++i)
        note_attempts(run, conversion.bodies[i], fmt::format("body {}, ", i + 1));
}

int convert_file(const ConvertCommandOptions& options) {
    RunFiles files{{options.input, options.cage_file},
                   {{"--output", options.output.file, OutputKind::Cad},
                    {"--cage-out", options.cage_out, OutputKind::Cage}}};
    for (const OutputFile& file : view_files(options.view)) files.outputs.push_back(file);
    Run run(options.common, files);
    const base::Budget budget = run.budget(options.fit.time_limit_s);
    convert::Source source =
        read_source(run, options.input, options.read, {.progress = budget.limited()});
    refuse_control_mesh(source);
    if (source.model)
        for (const auto& [a, b] : occ::overlapping_solids(*source.model))
            run.notice(fmt::format("solids {} and {} of {} overlap; they stay separate bodies", a,
                                   b, options.input));
    convert::ConvertOptions converting =
        convert_options(run, source, options.fit, options.cage, options.cage_file);
    if (!converting.cage) leave_out_narrow_holes(run, source, converting.tolerance_mm);
    run.report.unit = output_unit(options.output, source.input.unit);
    converting.shape = options.output.shape;
    converting.shape.write.unit = run.report.unit;
    converting.samples = options.samples;
    converting.normal_tolerance_rad = normal_tolerance_rad(options.normal_tolerance);
    const convert::Conversion conversion =
        convert::convert(source, options.output.file, run.outputs, converting, budget);
    for (const auto& [stage, seconds] : conversion.seconds) run.add_stage(stage, seconds);
    for (const std::string& text : conversion.notices) run.notice(text);
    note_attempts(run, conversion);
    if (conversion.time_limit_reached)
        run.notice(fmt::format("the time limit of {:g} s was reached", *options.fit.time_limit_s));
    if (!conversion.kept) throw base::TimeLimitReached();
    const convert::Attempt& best = conversion.attempts[*conversion.kept];
    convert::add_attempt(run.report, best);
    if (!options.cage_out.empty())
        write_cage(run, best.fitted, options.cage_out,
                   base::parse_length_unit(options.fit.cage_unit));
    add_views(run, options.view,
              {.output = best.output.get(),
               .input = &source.surface(),
               .cage = &best.fitted,
               .scale_mm = converting.tolerance_mm});
    return run.finish();
}

}  // namespace

void register_convert(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<ConvertCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "convert", "CAD file, with or without a cage, to one clean solid, measured");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("--cage", options->cage_file,
                        "control mesh (OBJ); by default it is made from the CAD");
    command->add_option("--cage-out", options->cage_out, "write the fitted control mesh (OBJ)");
    add_input_options(*command, options->read);
    add_foot_point_option(*command, options->read);
    command->add_option("--samples", options->samples, "samples for the deviation, each way")
        ->check(number_in(1, most_samples))
        ->capture_default_str();
    add_output_options(*command, options->output);
    add_view_options(*command, options->view, true);
    add_cage_options(*command, options->cage);
    add_fit_options(*command, options->fit);
    add_normal_tolerance_option(*command, options->normal_tolerance);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->input, [&] { return convert_file(*options); });
    });
}

}  // namespace patchwright::cli
