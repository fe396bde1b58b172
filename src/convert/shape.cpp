#include "convert/describe_patches.h"
#include "geom/disjoint_sets.h"

#include <patchwright/base/error.h>
#include <patchwright/convert/shape.h>
#include <patchwright/convert/source.h>
#include <patchwright/measure/deviation.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

namespace patchwright::convert {

namespace {

/// Along an edge, for gaps and kinks: a dozen a cage face of a long chart's side.
constexpr int continuity_samples = 33;

/// Of the diagonal: self-intersecting loops smaller than this are not looked for, however small the
/// tolerance: the search takes time in proportion to the pieces of that size beside folds.
constexpr double finest_resolution_rel = 1e-6;

/// A sharp curve of the input is long, and has to be kept, above so many tolerances.
constexpr double long_in_tolerances = 100.0;

report::DeviationFigures::LongSharpCurves long_sharp_curves(const geom::ModelSurface& output,
                                                            const geom::ModelSurface& input,
                                                            double tolerance_mm,
                                                            const base::Progress& progress) {
    report::DeviationFigures::LongSharpCurves result{
        .longer_than = long_in_tolerances * tolerance_mm, .tolerance = tolerance_mm};
    for (const auto& c :
         measure::measure_sharp_curves(input, output, result.longer_than, progress)) {
        ++result.count;
        if (c.distance > tolerance_mm) result.missed.push_back({c.length, c.distance, c.at});
    }
    std::stable_sort(result.missed.begin(), result.missed.end(),
                     [](const auto& a, const auto& b) { return a.distance > b.distance; });
    return result;
}

/// Names of more bytes keep their beginning and their end: readers of STEP, the kernel's among
/// them, have buffers of a few thousand bytes for one, and characters take up to ten.
constexpr std::size_t longest_name = 256;

std::string shortened(const std::string& name) {
    constexpr std::size_t kept_end = 40;  // holds the number of the patch
    constexpr std::string_view gap = "...";
    const auto inside_character = [&](std::size_t k) { return (name[k] & 0xC0) == 0x80; };
    std::size_t begin = longest_name - kept_end - gap.size(), end = name.size() - kept_end;
    while (begin > 0 && inside_character(begin)) --begin;
    while (end < name.size() && inside_character(end)) ++end;
    return name.substr(0, begin).append(gap).append(name.substr(end));
}

/// @return how many were too long
int shorten_names(patch::PatchSet& patches) {
    int count = 0;
    for (patch::Patch& patch : patches.patches) {
        if (patch.name.size() <= longest_name) continue;
        patch.name = shortened(patch.name);
        ++count;
    }
    return count;
}

/// By patch: the least number of those that hang together with it by common edges.
std::vector<int> bodies_of(const patch::PatchSet& patches) {
    geom::DisjointSets sets(patches.patches.size());
    std::vector<std::optional<int>> first(patches.edges.size());
    for (std::size_t p = 0; p < patches.patches.size(); ++p)
        for (const auto& side : patches.patches[p].sides)
            for (const patch::EdgeUse& use : side) {
                auto& other = first[std::size_t(use.edge)];
                if (other) sets.join(*other, int(p));
                other = int(p);
            }
    std::vector<int> bodies(patches.patches.size());
    for (std::size_t p = 0; p < bodies.size(); ++p) bodies[p] = sets.find(int(p));
    return bodies;
}

}  // namespace

Shape make_shape(const mesh::Cage& cage, const ShapeOptions& options, ShapeTolerance tolerance,
                 const geom::ReferenceSurface* source) {
    patch::Extraction extraction = patch::extract(cage, {.join = options.join,
                                                         .covering = options.covering,
                                                         .tolerance_mm = tolerance.caps_mm,
                                                         .cap_depth = options.cap_depth});
    describe_patches(extraction.patches, options.colouring, source, tolerance.whole_mm);
    const int shortened_names = shorten_names(extraction.patches);
    Shape shape{
        .model = occ::assemble(extraction.patches),
        .patches = {.count = static_cast<int>(extraction.patches.patches.size()),
                    .continuity = options.join == patch::Join::G1 ? "g1" : "refined",
                    .covering = options.covering == patch::Covering::Charts ? "charts" : "faces",
                    .caps = extraction.caps},
        .crease_points = patch::crease_midpoints(extraction.patches),
        .singular_points = patch::singular_points(extraction),
        .closed = mesh::summarise(*cage.topology).boundary_edges == 0,
        .tolerance_mm = tolerance.whole_mm};
    if (shortened_names > 0)
        shape.notices.push_back(
            fmt::format("{} names of faces have more than {} bytes and were shortened",
                        shortened_names, longest_name));
    for (patch::Patch& patch : extraction.patches.patches) {
        shape.patches.control_points += static_cast<int>(patch.surface.points.rows());
        shape.surfaces.push_back(std::move(patch.surface));
    }
    shape.bodies = bodies_of(extraction.patches);
    for (patch::PatchEdge& edge : extraction.patches.edges)
        if (edge.crease) shape.creases.push_back(std::move(edge.curve));
    return shape;
}

occ::CadModel write_and_read_back(const Shape& shape, base::PendingFile& file,
                                  const occ::WriteOptions& options) {
    occ::write_cad(shape.model, file, options);
    try {
        return occ::read_cad(file.path(), {.heal = false, .as_written = true}).model;
    } catch (const base::InputError& error) {
        throw base::OutputError(
            fmt::format("{}: what was written cannot be read back, and is not kept: {}",
                        file.target().given.string(), error.what()));
    }
}

ShapeFigures inspect_shape(const Shape& shape, const occ::CadModel& model, const std::string& file,
                           const base::Progress& progress) {
    ShapeFigures figures{
        .solid = solid_figures(file, model),
        .continuity = occ::measure_continuity(model, shape.crease_points,
                                              {.samples_per_edge = continuity_samples,
                                               .singular_points = shape.singular_points,
                                               .singular_distance_mm = shape.tolerance_mm}),
        .bodies = static_cast<int>(occ::connected_faces(model).size())};
    const double resolution =
        std::max(shape.tolerance_mm, finest_resolution_rel * figures.solid.bounds.diagonal());
    for (const measure::SelfIntersection& hit :
         measure::find_self_intersections(shape.surfaces, resolution, progress)) {
        const auto body = [&](int surface) { return shape.bodies[std::size_t(surface)]; };
        (body(hit.surfaces[0]) == body(hit.surfaces[1]) ? figures.self_intersections
                                                        : figures.crossing_bodies)
            .push_back(hit);
    }
    return figures;
}

std::optional<std::string> crossing_notice(const ShapeFigures& figures) {
    if (figures.crossing_bodies.empty()) return std::nullopt;
    return fmt::format(
        "{} pairs of faces of different bodies cross each other; the bodies stay separate",
        figures.crossing_bodies.size());
}

measure::VerdictFigures verdict_figures(const ShapeFigures& figures, bool closed) {
    const report::SolidFigures& solid = figures.solid;
    measure::VerdictFigures result{
        .diagonal_mm = solid.bounds.diagonal(),
        .valid = solid.valid,
        .bodies = figures.bodies,
        .kink_rad = measure::Worst{figures.continuity.max_kink_rad, figures.continuity.kink_at},
        .self_intersecting_faces = measure::Failures{},
        .patches = solid.faces,
        .closed = solid.closed};
    std::set<int> intersecting;
    for (const measure::SelfIntersection& hit : figures.self_intersections)
        intersecting.insert(hit.surfaces.begin(), hit.surfaces.end());
    result.self_intersecting_faces->count = int(intersecting.size());
    if (!intersecting.empty())
        result.self_intersecting_faces->at = figures.self_intersections.front().point;
    if (closed) result.free_edges = solid.free_edges;
    result.area_mm2 = solid.area;
    // Formats without solids give none back, and no volume.
    if (solid.solids > 0) result.volume_mm3 = solid.volume;
    return result;
}

report::DeviationFigures compare(const geom::ModelSurface& output, const geom::ModelSurface& input,
                                 int samples, std::optional<double> tolerance_mm,
                                 const base::Progress& progress) {
    const measure::DeviationMeasure measure{
        .samples = samples, .with_bound = false, .progress = progress};
    const measure::FeatureMeasure features{.progress = progress};
    const auto kind = geom::FeatureKind::Sharp;
    const auto count = [&](const geom::ModelSurface& surface) {
        const auto& curves = surface.features().curves;
        return static_cast<int>(std::count_if(curves.begin(), curves.end(),
                                              [&](const auto& c) { return c.kind == kind; }));
    };
    report::DeviationFigures figures{
        .output_to_input = measure::measure_deviation(output, input, measure),
        .input_to_output = measure::measure_deviation(input, output, measure),
        .sharp_curves_input = count(input),
        .sharp_curves_output = count(output),
        .sharp_output_to_input = measure::measure_feature_deviation(output, input, kind, features),
        .sharp_input_to_output = measure::measure_feature_deviation(input, output, kind, features)};
    figures.fairness = measure::measure_relative_fairness(
        output, input, {.samples = samples, .progress = progress});
    if (tolerance_mm)
        figures.long_sharp = long_sharp_curves(output, input, *tolerance_mm, progress);
    return figures;
}

void add_bounds(report::DeviationFigures& deviation, const geom::ModelSurface& output,
                const geom::ModelSurface& input, const base::Progress& progress) {
    measure::Deviation &out = deviation.output_to_input, &back = deviation.input_to_output;
    out.bound = measure::measure_bound(output, input, {.found_mm = out.max, .progress = progress});
    back.bound =
        measure::measure_bound(input, output, {.found_mm = back.max, .progress = progress});
}

void add_deviation(measure::VerdictFigures& figures, const report::DeviationFigures& deviation) {
    const auto worst = [](const measure::Deviation& d) { return measure::Worst{d.max, d.at}; };
    figures.output_to_input_mm = worst(deviation.output_to_input);
    figures.input_to_output_mm = worst(deviation.input_to_output);
    if (deviation.fairness) add_normals(figures, *deviation.fairness);
    if (!deviation.long_sharp) return;
    const auto& missed = deviation.long_sharp->missed;
    figures.lost_sharp_curves = measure::Failures{int(missed.size()), {}};
    if (!missed.empty()) figures.lost_sharp_curves->at = missed.front().at;
}

void add_normals(measure::VerdictFigures& figures, const measure::RelativeFairness& fairness) {
    const measure::Distribution& angle = fairness.normal_angle_rad;
    if (fairness.samples > 0) figures.normal_angle_rad = measure::Worst{angle.max, angle.at};
}

void add_fit(measure::VerdictFigures& figures, const report::FitFigures& fit) {
    const fit::FitLevel& best = fit.levels[std::size_t(fit.best_level)];
    const auto raise = [](std::optional<measure::Worst>& worst, double value,
                          const geom::Vec3& at) {
        if (!worst || value > worst->value)
            worst = {value, value > 0.0 ? std::optional(at) : std::nullopt};
    };
    raise(figures.output_to_input_mm, best.max_mm, best.max_at);
    raise(figures.output_to_input_mm, best.curve_max_mm, best.curve_max_at);
    raise(figures.input_to_output_mm, best.reverse_max_mm, best.reverse_max_at);
}

void add_folds(measure::VerdictFigures& figures, const measure::FoldFigures& folds) {
    const auto& worst = folds.worst;
    figures.fold_rad = worst ? measure::Worst{worst->angle_rad, worst->point} : measure::Worst{};
}

}  // namespace patchwright::convert
