#include "fit/loop/facing.h"
#include "fit/loop/measure.h"
#include "fit/loop/refinement.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace patchwright::fit {

namespace {

void check(const FitOptions& o) {
    const auto require = [](bool good, const char* what) {
        if (!good) throw base::InvalidArgument(fmt::format("fit: {}", what));
    };
    require(o.tolerance_mm > 0.0, "the tolerance must be positive");
    require(o.max_levels >= 0, "max_levels must not be negative");
    require(o.max_idle_levels >= 1, "max_idle_levels must be positive");
    require(o.max_projections >= 0, "max_projections must not be negative");
    require(o.reverse_samples >= 0, "reverse_samples must not be negative");
    require(o.samples_per_edge >= 2, "samples_per_edge must be at least 2");
    require(o.fairness >= 0.0, "fairness must not be negative");
    require(o.max_cgls_iterations >= 1, "max_cgls_iterations must be positive");
}

/// A level with what came of it.
struct Candidate {
    mesh::Cage cage;
    std::vector<FaceHistory> history;
    FitLevel level;
    LevelError error;
    int symmetry_axis = -1;
    int number = 0;
    double side_reach = std::numeric_limits<double>::infinity();  ///< see foot_on_side
};

void fit_candidate(Candidate& c, const geom::ReferenceSurface& reference,
                   const std::vector<geom::Vec3>& points, const FitOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    c.level.vertices = c.cage.topology->vertex_count();
    c.level.faces = c.cage.topology->face_count();
    FitOptions of_level = options;
    // Where strips of different width meet, bending would move more than it makes fair.
    if (c.level.local) of_level.fairness *= 1e-2;
    LevelFit fitted = fit_level(c.cage, reference, points, of_level, c.side_reach, c.level);
    c.cage.points = std::move(fitted.points);
    c.cage = subd::control_normals(c.cage);
    c.symmetry_axis = fitted.symmetry_axis;
    c.error = measure(c.cage, fitted, reference, points, options);
    c.level.samples = static_cast<int>(c.error.surface.count);
    c.level.rms_mm = c.error.surface.rms();
    c.level.max_mm = c.error.surface.max;
    c.level.reverse_max_mm = c.error.reverse.max;
    c.level.curve_max_mm = c.error.curves.max;
    c.level.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Times as far as on the level before no point can be from where it belongs.
constexpr double farthest = 10.0;

/// Whether the last levels have hardly come nearer than those before them, neither where they are
/// farthest nor on average: what is left then is not for want of control points.
bool is_stuck(const std::vector<FitLevel>& levels) {
    constexpr std::ptrdiff_t last = 3;
    constexpr double hardly = 0.95, hardly_on_average = 0.85;
    if (static_cast<std::ptrdiff_t>(levels.size()) <= last) return false;
    const auto least = [&](auto begin, auto end, const auto& figure) {
        double result = figure(*begin);
        for (; begin != end; ++begin) result = std::min(result, figure(*begin));
        return result;
    };
    const auto nearer = [&](const auto& figure, double share) {
        return least(levels.end() - last, levels.end(), figure) <
               share * least(levels.begin(), levels.end() - last, figure);
    };
    return !nearer([](const FitLevel& l) { return l.largest(); }, hardly) &&
           !nearer([](const FitLevel& l) { return l.rms_mm; }, hardly_on_average);
}

FitResult fit_facing(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                     const FitOptions& options) {
    std::vector<geom::Vec3> points;
    if (options.reverse_samples > 0)
        for (const auto& sample : reference.sample(options.reverse_samples))
            points.push_back(sample.point);
    FitResult result;
    Candidate now{.cage = cage};
    std::optional<Candidate> kept;  // the one to refine
    double least = std::numeric_limits<double>::infinity();
    bool last_resort = false;
    for (;;) {
        fit_candidate(now, reference, points, options);
        now.number = static_cast<int>(result.levels.size());
        result.levels.push_back(now.level);
        // Splitting strips moves the limit surface, and may leave it where steps do not lead back.
        const bool worse = kept && now.level.largest() > kept->level.largest() &&
                           now.level.rms_mm > kept->level.rms_mm;
        const bool retry = worse && now.level.local;
        if (now.level.largest() < least) {
            least = now.level.largest();
            result.cage = now.cage;
            result.symmetry_axis = now.symmetry_axis;
            result.best_level = now.number;
        }
        if (!worse) kept = std::move(now);
        result.met = least <= options.tolerance_mm;
        const bool room =
            static_cast<int>(result.levels.size()) <= options.max_levels &&
            static_cast<int>(result.levels.size()) <= result.best_level + options.max_idle_levels &&
            !is_stuck(result.levels);
        std::optional<NextLevel> next;
        if (!result.met && room && (retry || !worse)) {
            next = refine_where_needed(kept->cage, kept->error, kept->history, options,
                                       retry ? Refinement::Global : options.refinement);
        }
        // Faces that gain nothing from single cuts get one in both directions before it is over.
        if (!next && !result.met && room && kept->level.local && !last_resort) {
            last_resort = true;
            next = refine_where_needed(kept->cage, kept->error, {}, options, Refinement::Global);
        }
        if (!next) break;
        now = {.cage = std::move(next->cage),
               .history = std::move(next->history),
               .side_reach = farthest * kept->level.largest()};
        now.level.local = next->local;
    }
    return result;
}

}  // namespace

FitResult fit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options) {
    check(options);
    const bool away = faces_away(cage, reference);
    FitResult result = away ? fit_facing(cage, TurnedReference(reference), options)
                            : fit_facing(cage, reference, options);
    result.faces_away = away;
    return result;
}

}  // namespace patchwright::fit
