#include "fit/loop/facing.h"
#include "fit/loop/measure.h"
#include "fit/loop/placement.h"
#include "fit/loop/refinement.h"
#include "fit/loop/vertex_targets.h"
#include "measure/limit_folds.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/fit/interpolate.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

namespace patchwright::fit {

namespace {

void check(const FitOptions& o) {
    const auto require = [](bool good, const char* what) {
        if (!good) throw base::InvalidArgument(fmt::format("fit: {}", what));
    };
    require(o.tolerance_mm > 0.0, "the tolerance must be positive");
    require(o.max_levels >= 0, "max_levels must not be negative");
    require(o.max_idle_growth >= 1.0, "max_idle_growth must be at least 1");
    require(o.idle_share > 0.0 && o.idle_share <= 1.0, "idle_share must be above 0, at most 1");
    require(o.min_share_to_split_all >= 0.0, "min_share_to_split_all must not be negative");
    require(o.solver.max_projections >= 0, "max_projections must not be negative");
    require(o.reverse_samples >= 0, "reverse_samples must not be negative");
    require(o.solver.samples_per_edge >= 2, "samples_per_edge must be at least 2");
    require(o.solver.fairness >= 0.0, "fairness must not be negative");
    require(o.solver.tangential_scale_rel >= 0.0, "tangential_scale_rel must not be negative");
    require(o.solver.max_cgls_iterations >= 1, "max_cgls_iterations must be positive");
}

/// A level with what came of it.
struct Level {
    mesh::Cage cage;
    std::vector<FaceHistory> history;
    FitLevel figures;
    LevelError error;
    std::optional<int> symmetry_axis;
    LevelStart start;
};

void measure_level(Level& level, const LevelFit& fitted, const geom::ReferenceSurface& reference,
                   const std::vector<geom::Vec3>& points, const FitOptions& options) {
    level.error = measure(level.cage, fitted, reference, points, options);
    FitLevel& figures = level.figures;
    figures.vertices = level.cage.topology->vertex_count();
    figures.faces = level.cage.topology->face_count();
    figures.samples = static_cast<int>(level.error.surface.count);
    figures.rms_mm = level.error.surface.rms();
    figures.max_mm = level.error.surface.max;
    figures.max_at = level.error.surface.max_at;
    figures.reverse_max_mm = level.error.reverse.max;
    figures.reverse_max_at = level.error.reverse.max_at;
    figures.curve_max_mm = level.error.curves.max;
    figures.curve_max_at = level.error.curves.max_at;
    if (figures.largest() > options.tolerance_mm) return;
    const std::vector<int> folded =
        measure::folded_samples(level.cage, reference, options.tolerance_mm);
    for (std::size_t f = 0; f < folded.size(); ++f) level.error.faces[f].folded = folded[f];
    figures.folded = std::accumulate(folded.begin(), folded.end(), 0);
}

std::vector<geom::Vec3> reverse_points(const geom::ReferenceSurface& reference, int count) {
    std::vector<geom::Vec3> points;
    if (count == 0) return points;
    for (const geom::SurfaceSample& sample : reference.sample(count))
        points.push_back(sample.point);
    return points;
}

std::vector<geom::Vec3> misses(const mesh::Cage& cage, const std::vector<FaceError>& errors,
                               double tolerance) {
    std::vector<std::pair<double, geom::Vec3>> found;
    for (const mesh::FaceId f : cage.topology->faces()) {
        const FaceError& error = errors[f.index()];
        if (error.largest() <= tolerance && error.folded == 0) continue;
        geom::Vec3 middle = geom::Vec3::Zero();
        for (const auto c : cage.topology->corners(f))
            middle += cage.points.row(cage.topology->vertex(c).value).transpose();
        found.emplace_back(error.largest(), middle / cage.topology->size(f));
    }
    std::ranges::stable_sort(found, std::greater(), [](const auto& one) { return one.first; });
    std::vector<geom::Vec3> places;
    for (const auto& [distance, middle] : found) places.push_back(middle);
    return places;
}

// No foot point is farther than this times the largest distance of the level before.
constexpr double foot_reach_growth = 10.0;
// Where strips of different width meet, bending energy would move more than it makes fair.
constexpr double local_fairness = 1e-2;

/// Folded samples a face, which cuts leave as it is where the same part stays folded; infinite for
/// levels beyond the tolerance, which folds are not looked for in.
double folded_share(const FitLevel& level, double tolerance) {
    if (level.largest() > tolerance) return std::numeric_limits<double>::infinity();
    return double(level.folded) / double(level.faces);
}

/// Whether the last three levels have gained less than a twentieth of the largest distance and less
/// than a seventh of the mean one; once a level is within the tolerance, less than a seventh of
/// what is folded. Chosen on the samples, where nothing was gained after that: what is left is not
/// for want of control points.
bool is_stuck(const std::vector<FitLevel>& levels, double tolerance) {
    constexpr std::ptrdiff_t last = 3;
    constexpr double max_ratio = 0.95, max_mean_ratio = 0.85, max_folded_ratio = 0.85;
    if (static_cast<std::ptrdiff_t>(levels.size()) <= last) return false;
    const auto least = [&](auto begin, auto end, const auto& figure) {
        double result = figure(*begin);
        for (; begin != end; ++begin) result = std::min(result, figure(*begin));
        return result;
    };
    const auto is_less = [&](const auto& figure, double share) {
        return least(levels.end() - last, levels.end(), figure) <
               share * least(levels.begin(), levels.end() - last, figure);
    };
    const auto folded = [&](const FitLevel& l) { return folded_share(l, tolerance); };
    if (std::isfinite(least(levels.begin(), levels.end(), folded)))
        return !is_less(folded, max_folded_ratio);
    return !is_less([](const FitLevel& l) { return l.largest(); }, max_ratio) &&
           !is_less([](const FitLevel& l) { return l.rms_mm; }, max_mean_ratio);
}

/// Of a distance: what a level with so many times the faces may leave and still gain something.
double share_left(double idle_share, double growth) {
    return std::pow(idle_share, std::log(growth) / std::log(4.0));
}

/// Fits level after level to a reference that faces as the cage does.
class LevelLoop {
  public:
    LevelLoop(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options)
        : reference_(reference),
          options_(options),
          crease_rule_(options.crease_rule.value_or(cage.topology->crease_rule())),
          points_(reverse_points(reference, options.reverse_samples)),
          now_{.cage = placed(cage, reference, options)} {}

    FitResult run() && {
        try {
            do {
                fit_level_now();
                keep_what_is_nearer();
            } while (!result_.stopped_by_time_limit && refine());
        } catch (const base::TimeLimitReached&) {
            if (result_.levels.empty()) throw;
            result_.stopped_by_time_limit = true;
        }
        return std::move(result_);
    }

  private:
    void fit_level_now() {
        const auto start = std::chrono::steady_clock::now();
        // Refinement drops the rule where it did not act.
        if (const mesh::Topology& t = *now_.cage.topology; t.crease_rule() != crease_rule_)
            now_.cage.topology = std::make_shared<const mesh::Topology>(t.with(crease_rule_));
        FitOptions of_level = options_;
        if (now_.figures.local) of_level.solver.fairness *= local_fairness;
        LevelFit fitted =
            fit_level(now_.cage, reference_, points_, of_level, now_.start, now_.figures);
        if (fitted.stopped_by_time_limit) {
            if (!result_.levels.empty()) throw base::TimeLimitReached();
            result_.stopped_by_time_limit = true;
            of_level.progress = {};
        }
        now_.cage.points = std::move(fitted.points);
        now_.cage = subd::control_normals(now_.cage);
        now_.symmetry_axis = fitted.symmetry_axis;
        measure_level(now_, fitted, reference_, points_, of_level);
        now_.figures.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    void keep_what_is_nearer() {
        const FitLevel& figures = now_.figures;
        // Lines of split strips lie elsewhere, from where steps may not lead back (decision 022).
        worse_ = kept_ && figures.largest() > options_.tolerance_mm &&
                 figures.largest() > kept_->figures.largest() &&
                 figures.rms_mm > kept_->figures.rms_mm;
        retry_ = worse_ && figures.local;
        const double beyond = std::max(figures.largest(), options_.tolerance_mm);
        const bool opened = beyond == least_ && figures.folded < least_folded_;
        const double share = share_left(options_.idle_share, figures.faces / gained_.faces);
        if (opened || beyond < share * gained_.distance) gained_ = {beyond, double(figures.faces)};
        if (result_.levels.empty() || beyond < least_ || opened) {
            least_ = beyond;
            least_folded_ = figures.folded;
            result_.cage = now_.cage;
            result_.symmetry_axis = now_.symmetry_axis;
            result_.misses = misses(now_.cage, now_.error.faces, options_.tolerance_mm);
            result_.best_level = static_cast<int>(result_.levels.size());
        }
        result_.levels.push_back(figures);
        result_.within_tolerance = least_ <= options_.tolerance_mm;
        if (!worse_) kept_ = std::move(now_);
    }

    [[nodiscard]] bool may_go_on() const {
        const auto levels = static_cast<int>(result_.levels.size());
        return (!result_.within_tolerance || least_folded_ > 0) && levels <= options_.max_levels &&
               !is_stuck(result_.levels, options_.tolerance_mm);
    }

    /// Prepares the next level; false where there is none.
    bool refine() {
        if (!may_go_on()) return false;
        const double most_faces = options_.max_idle_growth * gained_.faces;
        std::optional<NextLevel> next;
        if (retry_ || !worse_) {
            next = refine_where_needed(kept_->cage, kept_->error, kept_->history, options_,
                                       retry_ ? RefinementScope::Global : options_.refinement,
                                       most_faces);
        }
        // Before giving up, faces that gained nothing from single cuts are cut in both directions.
        if (!next && kept_->figures.local && !last_resort_) {
            last_resort_ = true;
            next = refine_where_needed(kept_->cage, kept_->error, {}, options_,
                                       RefinementScope::Global, most_faces);
        }
        if (!next) return false;
        now_ = {.cage = std::move(next->cage),
                .history = std::move(next->history),
                .start = {.foot_reach = foot_reach_growth * kept_->figures.largest(),
                          .folded = {},
                          .refined = true}};
        for (const FaceHistory& h : now_.history) now_.start.folded.push_back(h.folded ? 1 : 0);
        now_.figures.local = next->local;
        return true;
    }

    const geom::ReferenceSurface& reference_;
    const FitOptions& options_;
    mesh::CreaseRule crease_rule_;
    std::vector<geom::Vec3> points_;  // of the reference
    Level now_;
    std::optional<Level> kept_;  // the one to refine
    bool worse_ = false, retry_ = false, last_resort_ = false;
    double least_ = std::numeric_limits<double>::infinity();  // at least the tolerance
    int least_folded_ = 0;
    struct Gained {
        double distance = std::numeric_limits<double>::infinity();  // at least the tolerance
        double faces = 1.0;
    };
    Gained gained_;  // the last level that gained something
    FitResult result_;
};

/// `work(reference)` with the reference facing as the cage does.
template <class Work>
FitResult with_facing(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                      const Work& work) {
    const bool away = faces_away(cage, reference);
    FitResult result = away ? work(TurnedReference(reference)) : work(reference);
    result.faces_away = away;
    return result;
}

/// @throw InputError for what interpolation would move, or does not see
void check_interpolation(const mesh::Topology& t) {
    for (const mesh::VertexId v : t.vertices())
        if (t.is_pinned(v))
            throw base::InputError(fmt::format(
                "vertex {} is pinned, and interpolation moves all; take the pin out", v.value));
    if (!t.sectors().empty())
        throw base::InputError(
            fmt::format("sector at vertex {}: points beside tagged sectors are moved before the "
                        "limit is taken, off what is interpolated; take the tag out",
                        t.sectors().front().vertex));
}

/// The only level: limit points of the vertices on their targets.
FitResult interpolated(const mesh::Cage& given, const geom::ReferenceSurface& reference,
                       const FitOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    check_interpolation(*given.topology);
    const mesh::Cage cage = placed(given, reference, options);
    const LevelFit matched = given_level(cage, reference, options);
    const InterpolationResult solved = interpolate_vertices(
        cage, vertex_targets(cage, reference, matched), {.progress = options.progress});
    const double limit = interpolation_limit_rel * reference.bounds().diagonal();
    if (!(solved.largest_distance <= limit))
        throw base::InputError(fmt::format(
            "no control points put the limit points of all vertices on the model: {:.3g} mm "
            "remain where {:.3g} mm are rounding; subdivide the cage once",
            solved.largest_distance, limit));
    Level level{.cage = solved.cage};
    level.figures.cgls_steps = solved.iterations;
    level.figures.interpolated_mm = solved.largest_distance;
    level.figures.chains_on_features =
        int(std::count_if(matched.match.paths.begin(), matched.match.paths.end(),
                          [](const FeaturePath& path) { return !path.empty(); }));
    measure_level(level, matched, reference, reverse_points(reference, options.reverse_samples),
                  options);
    level.figures.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return {.cage = level.cage,
            .within_tolerance = level.figures.largest() <= options.tolerance_mm,
            .levels = {level.figures}};
}

}  // namespace

FitResult fit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options) {
    check(options);
    return with_facing(cage, reference, [&](const geom::ReferenceSurface& facing) {
        return options.interpolate ? interpolated(cage, facing, options)
                                   : LevelLoop(cage, facing, options).run();
    });
}

FitResult measure_given(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                        const FitOptions& options) {
    return with_facing(cage, reference, [&](const geom::ReferenceSurface& facing) {
        Level level{.cage = cage};
        measure_level(level, given_level(cage, facing, options), facing,
                      reverse_points(facing, options.reverse_samples), options);
        return FitResult{.cage = cage,
                         .within_tolerance = level.figures.largest() <= options.tolerance_mm,
                         .levels = {level.figures}};
    });
}

}  // namespace patchwright::fit
