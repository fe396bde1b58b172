#include "command.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/inspect_closely.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

/// Of the tolerance, for caps at extraordinary vertices; the rest is for the fit.
constexpr double caps_share = 0.1;

struct ConvertOptions {
    CommonOptions common;
    OutputOptions output;
    FitCommandOptions fit;
    LayoutOptions layout;
    std::string input, cage, cage_out, input_unit;
    int samples = 20000;
};

int convert(const ConvertOptions& options) {
    occ::file_format(options.output.file);
    const auto cage_unit = base::parse_length_unit(options.fit.cage_unit);
    base::parse_length(options.fit.tolerance);

    Run run(options.common);
    mesh::Cage cage;
    if (!options.cage.empty()) cage = read_cage(run, options.cage, cage_unit);
    const Input input = read_input(run, options.input, options.input_unit);
    for (const auto& [a, b] : occ::overlapping_solids(input.model)) {
        run.notice(fmt::format("solids {} and {} of {} overlap; they stay separate bodies", a, b,
                               options.input));
    }
    if (options.output.unit != "input")
        run.report.unit = base::parse_length_unit(options.output.unit);
    const occ::CadReference reference(input.model, {.progress = run.progress()});
    if (options.cage.empty()) cage = make_cage(run, input, reference, options.layout);
    run.end_stage("layout");

    const mesh::Cage fitted = fit_cage(run, cage, reference, options.fit);
    if (!options.cage_out.empty()) write_cage(fitted, options.cage_out, cage_unit);
    const occ::CadModel written = write_patches(run, fitted, options.output, run.report.unit,
                                                caps_share * run.report.fit->tolerance, &reference);
    compare_models(run, occ::CadReference(written), reference, options.samples);
    run.end_stage("check");

    report::FitFigures& fit = *run.report.fit;
    const report::DeviationFigures& deviation = *run.report.deviation;
    fit.met = deviation.output_to_input.max <= fit.tolerance &&
              deviation.input_to_output.max <= fit.tolerance;
    run.finish();
    return fit.met ? Done : ToleranceMissed;
}

}  // namespace

void register_convert(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<ConvertOptions>();
    CLI::App* command = app.add_subcommand(
        "convert", "CAD file, with or without a cage, to one clean solid, measured");
    command->add_option("input", options->input, "CAD file: STEP, IGES or BREP")->required();
    command->add_option("--cage", options->cage,
                        "control mesh (OBJ); left away: made from the CAD");
    command->add_option("--cage-out", options->cage_out, "write the fitted control mesh (OBJ)");
    command->add_option("--input-unit", options->input_unit,
                        "overrides the unit written in the input");
    command->add_option("--samples", options->samples, "samples for the deviation, each way")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    add_output_options(*command, options->output);
    add_layout_options(*command, options->layout);
    add_fit_options(*command, options->fit);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = convert(*options); });
}

}  // namespace patchwright::cli
