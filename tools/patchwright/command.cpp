#include "command.h"

#include "describe_patches.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/base/pending_file.h>
#include <patchwright/fit/fit.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/deviation.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

namespace patchwright::cli {

volatile std::sig_atomic_t interrupted = 0;

namespace {

constexpr int continuity_samples = 33;  // an edge

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html) {
    command.add_flag("-q,--quiet", options.quiet, "print errors only");
    command.add_flag("-v,--verbose", options.verbose, "print stage times as they end");
    command.add_flag("--progress", options.progress,
                     "show progress even where there is no terminal");
    command.add_option("--threads", options.threads, "threads to use; 0: all cores")
        ->check(CLI::NonNegativeNumber);
    command.add_option("--json", options.json, "write the report as JSON ('-': standard output)");
    if (with_html) command.add_option("--report", options.html, "write the report as HTML");
}

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

void add_input_options(CLI::App& command, InputOptions& options) {
    command.add_option("--input-unit", options.unit,
                       "overrides the unit written in the input; STL and OBJ have none: mm");
    command
        .add_option("--sharp-angle", options.sharp_angle_deg,
                    "edges whose faces differ by more than this are sharp, degrees; left away: 20, "
                    "for triangles 35")
        ->check(CLI::Range(0.1, 179.0));
}

void add_fit_options(CLI::App& command, FitCommandOptions& options) {
    command
        .add_option("--tolerance", options.tolerance,
                    "largest deviation: 0.05mm, 0.002in, or 1e-4rel (of the diagonal)")
        ->capture_default_str();
    command
        .add_option("--cage-unit", options.cage_unit,
                    "unit of the cage's numbers: mm, cm, m, in, ft")
        ->capture_default_str();
    command.add_option("--max-levels", options.max_levels, "refinements of the cage at most")
        ->check(CLI::Range(0, 20))
        ->capture_default_str();
    command
        .add_option("--refine", options.refine,
                    "where the cage is too coarse: local (strips of quads there are split "
                    "lengthwise) or global (every face in four)")
        ->check(CLI::IsMember({"local", "global"}))
        ->capture_default_str();
    command
        .add_option("--symmetry", options.symmetry,
                    "plane that a half model ends on: x, y or z (where that coordinate is 0), "
                    "detect or none")
        ->check(CLI::IsMember({"detect", "x", "y", "z", "none"}))
        ->capture_default_str();
}

void add_layout_options(CLI::App& command, LayoutOptions& options) {
    command
        .add_option(
            "--layout", options.method,
            "how a cage is made: aligned (blocks along the lines of a wing or of the faces), "
            "remesh (any shape, more patches), or auto (aligned where it is found)")
        ->check(CLI::IsMember({"aligned", "remesh", "auto"}))
        ->capture_default_str();
    command
        .add_option("--target-faces", options.target_faces,
                    "number of faces to aim at, roughly; left away: as the shape asks for")
        ->check(CLI::PositiveNumber);
}

Run::Run(const CommonOptions& options)
    : options_(options), stage_start_(std::chrono::steady_clock::now()) {
    base::set_thread_count(options.threads);
}

base::Progress Run::progress() const {
    const bool show = !options_.quiet && (options_.progress || ::isatty(STDERR_FILENO) != 0);
    return [show, last = std::string(), start = stage_start_](std::string_view stage,
                                                              double fraction) mutable {
        if (show) {
            const double seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            const auto line =
                fmt::format("{:<10} {:3.0f} % {:6.1f} s", stage, 100 * fraction, seconds);
            if (line != last) fmt::print(stderr, "\r{}\033[K", line);
            std::fflush(stderr);
            last = line;
        }
        return interrupted == 0;
    };
}

void Run::end_stage(const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - stage_start_).count();
    const auto known = std::find_if(report.seconds.begin(), report.seconds.end(),
                                    [&](const auto& stage) { return stage.first == name; });
    if (known == report.seconds.end()) {
        report.seconds.emplace_back(name, seconds);
    } else {
        known->second += seconds;
    }
    stage_start_ = now;
    if (options_.verbose) fmt::print(stderr, "{}: {:.2f} s\n", name, seconds);
    if (interrupted != 0) throw base::Cancelled();
}

void Run::notice(const std::string& text) {
    report.notices.push_back(text);
    if (!options_.quiet) fmt::print(stderr, "note: {}\n", text);
}

void Run::finish() {
    if (!options_.quiet && (options_.progress || ::isatty(STDERR_FILENO) != 0)) {
        fmt::print(stderr, "\r\033[K");
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    report.peak_memory_mb = double(usage.ru_maxrss) / 1024.0;
    if (!options_.html.empty()) base::write_text_file(options_.html, report::to_html(report));
    if (options_.json == "-") {
        fmt::print("{}", report::to_json(report));
        return;
    }
    if (!options_.json.empty()) base::write_text_file(options_.json, report::to_json(report));
    if (!options_.quiet) fmt::print("{}", report::to_text(report));
}

mesh::Cage read_cage(Run& run, const std::string& file, base::LengthUnit unit) {
    mesh::BuildResult result = mesh::read_obj(std::filesystem::path(file));
    result.cage.points *= base::millimetres_per(unit);
    run.report.cage = mesh::summarise(*result.cage.topology);
    if (result.flipped_faces > 0) {
        run.notice(fmt::format("{}: {} faces were turned to agree with the others", file,
                               result.flipped_faces));
    }
    return std::move(result.cage);
}

layout::CageResult make_cage(Run& run, const Input& input, const LayoutOptions& options,
                             double tolerance_rel) {
    const auto method = options.method == "aligned"  ? layout::Method::Aligned
                        : options.method == "remesh" ? layout::Method::Remesh
                                                     : layout::Method::Auto;
    const layout::CageOptions making{.method = method,
                                     .target_faces = options.target_faces,
                                     .tolerance_rel = tolerance_rel,
                                     .fineness = options.fineness,
                                     .finer_at = options.finer_at,
                                     .progress = run.progress()};
    layout::CageResult result = input.mesh ? layout::make_cage(*input.mesh, making)
                                           : layout::make_cage(*input.model, *input.cad, making);
    for (const std::string& text : result.notices) run.notice(text);
    run.report.cage = mesh::summarise(*result.cage.topology);
    run.report.layout = result.layout;
    return result;
}

double relative_tolerance(const FitCommandOptions& options,
                          const geom::ReferenceSurface& reference) {
    const double diagonal = reference.bounds().diagonal();
    return base::parse_length(options.tolerance).in_millimetres(diagonal) / diagonal;
}

FitCommandOptions for_made_cage(FitCommandOptions options, const layout::CageResult& made) {
    // Blocks are coarse and refined in single strips; remeshed cages grow fourfold.
    constexpr int most_levels = 2, most_levels_of_blocks = 5, most_vertices = 40000;
    // Remeshed faces and blocks have the form they happen to have.
    options.keeps_form = made.method == layout::Method::Aligned && !made.from_faces;
    if (options.keeps_form) return options;
    options.max_levels =
        std::min(options.max_levels, made.from_faces ? most_levels_of_blocks : most_levels);
    options.max_vertices = std::min(options.max_vertices, most_vertices);
    return options;
}

void write_cage(const mesh::Cage& cage, const std::string& file, base::LengthUnit unit) {
    mesh::Cage scaled = cage;
    scaled.points /= base::millimetres_per(unit);
    base::write_text_file(file, mesh::obj_text(scaled));
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
    run.report.continuity =
        occ::measure_continuity(output.model, output.crease_points, continuity_samples);
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
    for (const auto& c : occ::measure_sharp_curves(input, output, result.longer_than)) {
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
    const occ::DeviationMeasure measure{
        .samples = samples, .with_bound = with_bound, .progress = run.progress()};
    const auto kind = geom::FeatureKind::Sharp;
    const auto count = [&](const geom::ModelSurface& reference) {
        const auto& curves = reference.features().curves;
        return static_cast<int>(std::count_if(curves.begin(), curves.end(),
                                              [&](const auto& c) { return c.kind == kind; }));
    };
    run.report.deviation = report::DeviationFigures{
        .output_to_input = occ::measure_deviation(output, input, measure),
        .input_to_output = occ::measure_deviation(input, output, measure),
        .sharp_curves_input = count(input),
        .sharp_curves_output = count(output),
        .sharp_output_to_input = occ::measure_feature_deviation(output, input, kind),
        .sharp_input_to_output = occ::measure_feature_deviation(input, output, kind)};
    if (tolerance_mm)
        run.report.deviation->long_sharp = long_sharp_curves(output, input, *tolerance_mm);
}

void bound_deviation(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input) {
    fit::Deviation& out = run.report.deviation->output_to_input;
    fit::Deviation& back = run.report.deviation->input_to_output;
    out.bound = occ::measure_bound(output, input, out.max, run.progress());
    back.bound = occ::measure_bound(input, output, back.max, run.progress());
}

namespace {

fit::Symmetry symmetry_option(const std::string& name) {
    if (name == "none") return fit::Symmetry::None;
    if (name == "detect") return fit::Symmetry::Detect;
    return name == "x" ? fit::Symmetry::X : name == "y" ? fit::Symmetry::Y : fit::Symmetry::Z;
}

}  // namespace

std::optional<PartFits> part_fits(Run& run, const Input& input) {
    if (!input.model || occ::connected_faces(*input.model).size() < 2) return std::nullopt;
    return PartFits{layout::model_bodies(*input.model, reference_options(run, input)), {}};
}

namespace {

/// Nothing where there are no bodies, or parts that lie on none of them alone: of the whole model
/// such a part would be drawn to what others are for.
std::optional<fit::FitResult> fit_by_parts(const mesh::Cage& cage,
                                           const geom::ModelSurface& reference,
                                           const fit::FitOptions& options, PartFits* by_parts) {
    if (by_parts == nullptr) return std::nullopt;
    const auto parts = mesh::connected_parts(cage);
    const auto references = layout::references_of_parts(parts, by_parts->bodies, reference);
    if (std::find(references.begin(), references.end(), &reference) != references.end())
        return std::nullopt;
    auto fitted = fit::fit_parts(parts, references, options, by_parts->known);
    by_parts->known.insert(by_parts->known.end(), std::make_move_iterator(fitted.parts.begin()),
                           std::make_move_iterator(fitted.parts.end()));
    return std::move(fitted.whole);
}

}  // namespace

mesh::Cage fit_cage(Run& run, const mesh::Cage& cage, const geom::ModelSurface& reference,
                    const FitCommandOptions& options, PartFits* by_parts) {
    const double diagonal = reference.bounds().diagonal();
    const double tolerance = base::parse_length(options.tolerance).in_millimetres(diagonal);
    const double size_ratio = geom::bounding_box(cage.points).diagonal() / diagonal;
    if (size_ratio < 0.5 || size_ratio > 2.0) {
        run.notice(
            fmt::format("the cage is {:.3g} times as large as the model; if its unit is not {}, "
                        "pass --cage-unit",
                        size_ratio, options.cage_unit));
    }
    // The rest of the tolerance is for caps, and for what lies between the fit's samples.
    const fit::FitOptions fitting{
        .tolerance_mm = 0.9 * tolerance,
        .refinement = options.refine == "local" ? fit::Refinement::Local : fit::Refinement::Global,
        .max_levels = options.max_levels,
        .max_vertices = options.max_vertices,
        .keeps_form = options.keeps_form,
        .symmetry = symmetry_option(options.symmetry),
        .progress = run.progress()};
    std::optional<fit::FitResult> of_parts = fit_by_parts(cage, reference, fitting, by_parts);
    fit::FitResult result = of_parts ? std::move(*of_parts) : fit::fit(cage, reference, fitting);
    if (result.faces_away) {
        run.notice(
            "the cage faces the other way than the model; it was fitted so, and so does the result "
            "(reverse the order of the vertices of its faces to turn it)");
    }
    const fit::FitLevel& best = result.levels[std::size_t(result.best_level)];
    run.report.fit = report::FitFigures{.tolerance = tolerance,
                                        .met = best.largest() <= tolerance,
                                        .best_level = result.best_level,
                                        .symmetry_axis = result.symmetry_axis,
                                        .before = fit::measure_fairness(cage),
                                        .after = fit::measure_fairness(result.cage),
                                        .levels = result.levels};
    run.end_stage("fit");
    return std::move(result.cage);
}

}  // namespace patchwright::cli
