#include "fitting.h"

#include <patchwright/mesh/parts.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::cli {

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

cage::CageResult make_cage(Run& run, const Input& input, const LayoutOptions& options,
                           double tolerance_rel) {
    const auto method = options.method == "aligned"  ? cage::Method::Aligned
                        : options.method == "remesh" ? cage::Method::Remesh
                                                     : cage::Method::Auto;
    const cage::CageOptions making{.method = method,
                                   .target_faces = options.target_faces,
                                   .tolerance_rel = tolerance_rel,
                                   .fineness = options.fineness,
                                   .finer_at = options.finer_at,
                                   .progress = run.progress()};
    cage::CageResult result = cage::make_cage(input.reference(), making);
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

FitCommandOptions for_made_cage(FitCommandOptions options, const cage::CageResult& made) {
    // Blocks are coarse and refined in single strips; remeshed cages grow fourfold. Blocks that
    // need many times the faces they came with are not what the model is like.
    constexpr int most_levels = 2, most_levels_of_blocks = 5, most_vertices = 40000;
    constexpr int most_vertices_of_block = 12, vertices_to_begin_with = 2000;
    // Another cage may serve better than levels that gain nothing.
    options.max_idle_levels = std::min(options.max_idle_levels, 2);
    // Remeshed faces and blocks have the form they happen to have.
    options.preserve_parametrisation = made.method == cage::Method::Aligned && !made.from_faces;
    if (options.preserve_parametrisation) return options;
    options.max_levels =
        std::min(options.max_levels, made.from_faces ? most_levels_of_blocks : most_levels);
    const int faces = made.cage.topology->face_count();
    options.max_vertices =
        std::min({options.max_vertices, most_vertices,
                  made.from_faces ? vertices_to_begin_with + most_vertices_of_block * faces
                                  : most_vertices});
    return options;
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
    return PartFits{occ::body_references(*input.model, reference_options(run, input)), {}};
}

namespace {

/// Nothing where there are no bodies, or parts that lie on none of them alone: of the whole model
/// such a part would be drawn to what others are for.
std::optional<fit::FitResult> fit_by_parts(const mesh::Cage& cage,
                                           const geom::ModelSurface& reference,
                                           const fit::FitOptions& options, PartFits* by_parts) {
    if (by_parts == nullptr) return std::nullopt;
    const auto parts = mesh::connected_parts(cage);
    const auto references = cage::references_of_parts(parts, by_parts->bodies, reference);
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
    const fit::FitOptions fitting{
        .tolerance_mm = (1.0 - caps_share) * tolerance,
        .refinement = options.refine == "local" ? fit::Refinement::Local : fit::Refinement::Global,
        .max_levels = options.max_levels,
        .max_vertices = options.max_vertices,
        .max_idle_levels = options.max_idle_levels,
        .preserve_parametrisation = options.preserve_parametrisation,
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
                                        .before = measure::measure_fairness(cage),
                                        .after = measure::measure_fairness(result.cage),
                                        .levels = result.levels};
    run.end_stage("fit");
    return std::move(result.cage);
}

}  // namespace patchwright::cli
