#include "output.h"

#include "describe_patches.h"
#include "input.h"

#include <patchwright/measure/deviation.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <algorithm>

namespace patchwright::cli {

namespace {

constexpr int continuity_samples = 33;  // an edge

}  // namespace

void add_output_options(CLI::App& command, OutputOptions& options) {
    command
        .add_option("-o,--output", options.file, "CAD file to write: .step .stp .igs .iges .brep")
        ->required();
    command.add_option("--unit", options.unit, "unit of the output: mm, cm, m, in, ft or input")
        ->capture_default_str();
    command.add_option("--schema", options.schema, "STEP schema")
        ->check(CLI::IsMember({"ap203", "ap214", "ap242"}))
        ->capture_default_str();
    command
        .add_option(
            "--continuity", options.continuity,
            "at extraordinary vertices: g1 (tangent planes agree exactly) or refined (knots "
            "towards the vertex, a small kink remains)")
        ->check(CLI::IsMember({"g1", "refined"}))
        ->capture_default_str();
    command
        .add_option("--patches", options.patches,
                    "charts (one surface for as many cage faces as possible) or faces (one each)")
        ->check(CLI::IsMember({"charts", "faces"}))
        ->capture_default_str();
    command
        .add_option("--color", options.colour,
                    "faces in STEP: none, kind (blue: regular, orange: with an extraordinary "
                    "corner), or deviation (from the input: blue 0, red the tolerance or more)")
        ->check(CLI::IsMember({"none", "kind", "deviation"}))
        ->capture_default_str();
    command.add_flag("--time-stamp", options.time_stamp,
                     "write the time into the file, which then differs from run to run");
    command
        .add_option(
            "--cap-depth", options.cap_depth,
            "knot levels towards an extraordinary vertex; left away: as the tolerance needs")
        ->check(CLI::Range(1, patch::max_cap_depth));
}

Assembled assemble_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                           double tolerance_mm, const geom::ReferenceSurface* source) {
    patch::ExtractOptions extract_options{.tolerance_mm = tolerance_mm};
    if (options.continuity == "refined") extract_options.join = patch::Join::Refined;
    if (options.patches == "faces") extract_options.covering = patch::Covering::Faces;
    if (options.cap_depth > 0) extract_options.cap_depth = options.cap_depth;
    patch::Extraction extraction = patch::extract(cage, extract_options);
    describe_patches(extraction.patches, options.colour, source,
                     run.report.fit ? run.report.fit->tolerance : tolerance_mm);
    report::PatchFigures figures{.count = static_cast<int>(extraction.patches.patches.size()),
                                 .continuity = options.continuity,
                                 .covering = options.patches,
                                 .caps = extraction.caps};
    for (const patch::Patch& patch : extraction.patches.patches) {
        figures.control_points += static_cast<int>(patch.surface.points.rows());
    }
    run.report.patches = figures;
    Assembled result{occ::assemble(extraction.patches),
                     patch::crease_midpoints(extraction.patches)};
    run.end_stage("patch");
    return result;
}

occ::CadModel write_assembled(Run& run, const Assembled& assembled, const OutputOptions& options,
                              base::LengthUnit unit) {
    const auto schema = options.schema == "ap203"   ? occ::StepSchema::Ap203
                        : options.schema == "ap242" ? occ::StepSchema::Ap242
                                                    : occ::StepSchema::Ap214;
    occ::write_cad(assembled.model, options.file,
                   {.unit = unit, .schema = schema, .time_stamp = options.time_stamp});
    run.end_stage("write");

    occ::CadModel written = occ::read_cad(options.file, {.heal = false}).model;
    inspect_output(run, {written, assembled.crease_points}, options.file);
    return written;
}

void inspect_output(Run& run, const Assembled& output, const std::string& file) {
    run.report.solid = solid_figures(file, output.model);
    run.report.continuity = occ::measure_continuity(output.model, output.crease_points,
                                                    {.samples_per_edge = continuity_samples});
}

occ::CadModel write_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                            base::LengthUnit unit, double tolerance_mm,
                            const geom::ReferenceSurface* source) {
    occ::file_format(options.file);  // refuses an unknown extension before the work
    return write_assembled(run, assemble_patches(run, cage, options, tolerance_mm, source), options,
                           unit);
}

namespace {

report::DeviationFigures::LongSharpCurves long_sharp_curves(const geom::ModelSurface& output,
                                                            const geom::ModelSurface& input,
                                                            double tolerance_mm) {
    constexpr double long_in_tolerances = 100.0;
    report::DeviationFigures::LongSharpCurves result{
        .longer_than = long_in_tolerances * tolerance_mm, .tolerance = tolerance_mm};
    for (const auto& c : measure::measure_sharp_curves(input, output, result.longer_than)) {
        ++result.count;
        if (c.distance > tolerance_mm) result.missed.push_back({c.length, c.distance, c.at});
    }
    std::stable_sort(result.missed.begin(), result.missed.end(),
                     [](const auto& a, const auto& b) { return a.distance > b.distance; });
    return result;
}

}  // namespace

void compare_models(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input,
                    int samples, std::optional<double> tolerance_mm, bool with_bound) {
    const measure::DeviationMeasure measure{
        .samples = samples, .with_bound = with_bound, .progress = run.progress()};
    const auto kind = geom::FeatureKind::Sharp;
    const auto count = [&](const geom::ModelSurface& reference) {
        const auto& curves = reference.features().curves;
        return static_cast<int>(std::count_if(curves.begin(), curves.end(),
                                              [&](const auto& c) { return c.kind == kind; }));
    };
    run.report.deviation = report::DeviationFigures{
        .output_to_input = measure::measure_deviation(output, input, measure),
        .input_to_output = measure::measure_deviation(input, output, measure),
        .sharp_curves_input = count(input),
        .sharp_curves_output = count(output),
        .sharp_output_to_input = measure::measure_feature_deviation(output, input, kind),
        .sharp_input_to_output = measure::measure_feature_deviation(input, output, kind)};
    if (tolerance_mm)
        run.report.deviation->long_sharp = long_sharp_curves(output, input, *tolerance_mm);
}

void bound_deviation(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input) {
    measure::Deviation& out = run.report.deviation->output_to_input;
    measure::Deviation& back = run.report.deviation->input_to_output;
    out.bound = measure::measure_bound(output, input, out.max, run.progress());
    back.bound = measure::measure_bound(input, output, back.max, run.progress());
}

}  // namespace patchwright::cli
