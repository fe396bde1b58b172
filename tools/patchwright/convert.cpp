#include "command.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/inspect_closely.h>

#include <fmt/format.h>

#include <algorithm>
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

// A second, finer cage is not tried when it has more faces than this.
constexpr int most_faces_again = 3000;

struct Attempt {
    mesh::Cage fitted;
    report::RunReport report;
    double deviation = 0.0;  ///< the larger one of both ways, of the diagonal
    double tolerance = 0.0;  ///< of the diagonal

    [[nodiscard]] bool met() const { return deviation <= tolerance; }
};

/// How far caps may lie from the limit surface, millimetres.
double caps(const Run& run) { return caps_share * run.report.fit->tolerance; }

/// Fits, writes and measures.
Attempt attempt(Run& run, const ConvertOptions& options, const mesh::Cage& cage,
                const occ::CadReference& reference) {
    Attempt result;
    result.fitted = fit_cage(run, cage, reference, options.fit);
    const occ::CadModel written =
        write_patches(run, result.fitted, options.output, run.report.unit, caps(run), &reference);
    compare_models(run, occ::CadReference(written), reference, options.samples);
    run.end_stage("check");
    const report::DeviationFigures& deviation = *run.report.deviation;
    const double diagonal = reference.bounds().diagonal();
    result.deviation =
        std::max(deviation.output_to_input.max, deviation.input_to_output.max) / diagonal;
    result.tolerance = run.report.fit->tolerance / diagonal;
    run.report.fit->met = result.met();
    result.report = run.report;
    return result;
}

int finish(Run& run, const ConvertOptions& options, const Attempt& attempt) {
    if (!options.cage_out.empty())
        write_cage(attempt.fitted, options.cage_out,
                   base::parse_length_unit(options.fit.cage_unit));
    run.finish();
    return attempt.met() ? Done : ToleranceMissed;
}

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
    if (!options.cage.empty()) {
        run.end_stage("layout");
        return finish(run, options, attempt(run, options, cage, reference));
    }
    const double tolerance = relative_tolerance(options.fit, reference);
    const layout::CageResult made = make_cage(run, input, reference, options.layout, tolerance);
    run.end_stage("layout");
    const Attempt first = attempt(run, options, made.cage, reference);
    if (first.met()) return finish(run, options, first);
    // Far off, the recognised shape is not what the model is; near, it needs more faces.
    LayoutOptions again = options.layout;
    const bool far_off = first.deviation > 10.0 * first.tolerance;
    if (far_off && again.method == "auto") again.method = "remesh";
    const bool other = far_off && made.method == layout::Method::Aligned;
    const layout::CageResult finer =
        make_cage(run, input, reference, again, tolerance, other ? 1.0 : 2.0);
    run.end_stage("layout");
    if (finer.cage.topology->face_count() > most_faces_again) {
        run.report = first.report;
        return finish(run, options, first);
    }
    const Attempt second = attempt(run, options, finer.cage, reference);
    run.notice(
        fmt::format("a cage of {} faces left {:.2g} of the diagonal; tried one of {} faces: {:.2g}",
                    made.cage.topology->face_count(), first.deviation,
                    finer.cage.topology->face_count(), second.deviation));
    if (second.deviation < first.deviation) return finish(run, options, second);
    const auto seconds = run.report.seconds;
    const auto notices = run.report.notices;
    run.report = first.report;
    run.report.seconds = seconds;
    run.report.notices = notices;
    write_patches(run, first.fitted, options.output, run.report.unit, caps(run), &reference);
    return finish(run, options, first);
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
