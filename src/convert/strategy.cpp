#include <patchwright/convert/convert.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::convert {

namespace {

/// A result that is farther off than so many tolerances has a cage of the wrong shape: finer lines
/// of the same layout do not mend that.
constexpr double far_off = 10.0;
/// Another cage of the same kind is made while the last one reduced the worst excess at least so
/// far; halved edges reduce it to a quarter or less where more control points are what is missing.
constexpr double least_gain = 0.8;
/// Of the diagonal: balls around places that miss, in which a remeshed cage gets shorter edges.
constexpr double ball_radius_rel = 0.02;
/// Halvings of a remeshed cage's edges around one place. What an eighth of the first length does
/// not mend is not for want of control points.
constexpr int most_halvings = 3;
/// Places count that have used up so much of the tolerance: their neighbourhood may miss.
constexpr double nearly_missed = 0.8;

/// Fits that aim at less than this share of the tolerance cost more control points than a finer
/// cage.
constexpr double least_fit_share = 0.5;
/// The same where normals ask for it, which no distance limits.
constexpr double least_share_for_normals = 1e-3;

double worst_excess(const Attempt& attempt) {
    const measure::Condition* worst = attempt.verdict.worst();
    return worst == nullptr ? 1.0 : measure::excess(*worst);
}

bool meets(const Attempt& attempt, measure::Requirement requirement) {
    const auto& conditions = attempt.verdict.conditions;
    return std::all_of(conditions.begin(), conditions.end(), [&](const measure::Condition& c) {
        return c.met || c.requirement != requirement;
    });
}

/// Near enough, but with folds, kinks or loops, or normals off: what is smaller than the tolerance
/// goes away where the fit comes nearer.
bool misses_shape_only(const Attempt& attempt) {
    const auto is_shape = [](const measure::Condition& c) {
        using measure::Requirement;
        return c.met || c.requirement == Requirement::Folds ||
               c.requirement == Requirement::Normals || c.requirement == Requirement::Kinks ||
               c.requirement == Requirement::SelfIntersections;
    };
    const auto& conditions = attempt.verdict.conditions;
    return !attempt.verdict.met() && std::all_of(conditions.begin(), conditions.end(), is_shape);
}

/// The fit has met its own samples, and the check found what lies between them. A sharp curve that
/// is lost is no matter of nearness: the cage has no crease along it.
bool misses_between_samples(const Attempt& attempt) {
    const report::FitFigures& fit = attempt.fit;
    return !fit.levels.empty() && worst_excess(attempt) <= far_off &&
           meets(attempt, measure::Requirement::SharpCurves) &&
           fit.levels[std::size_t(fit.best_level)].largest() <= fit.tolerance;
}

/// Whether the same cage is to be fitted nearer. Finer lines of a field mend folds in more cases.
bool nearer_helps(const Attempt& last) {
    if (last.plan.fit_share <= least_fit_share) return false;
    if (last.kind != CageKind::Sections && last.kind != CageKind::Field) return false;
    if (misses_shape_only(last)) return last.kind == CageKind::Sections || last.finer_refused;
    return misses_between_samples(last);
}

/// The same cage fitted so much nearer that its normals should be within their limit: under
/// refinement the distance goes down with the fourth power of the edges' length, normals with the
/// third. Nothing where anything else misses.
std::optional<AttemptPlan> nearer_for_normals(const Attempt& last) {
    using measure::Requirement;
    const measure::Condition* normals = nullptr;
    for (const measure::Condition& c : last.verdict.conditions) {
        if (c.met) continue;
        if (c.requirement != Requirement::Normals) return std::nullopt;
        normals = &c;
    }
    if (normals == nullptr || last.plan.fit_share < least_share_for_normals) return std::nullopt;
    AttemptPlan nearer = last.plan;
    nearer.fit_share *= std::min(0.5, std::pow(measure::excess(*normals), -4.0 / 3.0));
    return nearer;
}

/// The better one of the attempts with the last one's cage.
const Attempt& best_of_last_cage(const std::vector<Attempt>& attempts) {
    const Attempt* best = &attempts.back();
    for (auto a = attempts.rbegin(); a != attempts.rend(); ++a) {
        if (!a->plan.same_cage(attempts.back().plan)) break;
        if (measure::better(a->verdict, best->verdict)) best = &*a;
    }
    return *best;
}

/// Whether the last cage is the first of its kind or came clearly nearer than those before it.
bool gained(const std::vector<Attempt>& attempts) {
    const Attempt& last = best_of_last_cage(attempts);
    double before = std::numeric_limits<double>::infinity();
    for (const Attempt& a : attempts)
        if (a.kind == last.kind && !a.plan.same_cage(last.plan))
            before = std::min(before, worst_excess(a));
    return worst_excess(last) < least_gain * before;
}

/// A remeshed cage with shorter edges around the places that miss; nothing where edges have been
/// halved there as often as they may be.
std::optional<AttemptPlan> finer_remeshed(const Attempt& last, const ConvertOptions& options,
                                          double diagonal) {
    AttemptPlan plan{.cage = last.plan.cage};
    plan.cage.method = cage::Method::Remesh;
    cage::FinerRegion region;
    const auto add = [&](const geom::Vec3& place) {
        const auto within = [&](double radius) {
            return [&place, radius](const cage::FinerRegion::Ball& ball) {
                return (ball.centre - place).norm() < radius;
            };
        };
        const auto halved = [&](const cage::FinerRegion& earlier) {
            return std::ranges::any_of(earlier.balls, within(ball_radius_rel * diagonal));
        };
        if (std::ranges::any_of(region.balls, within(0.5 * ball_radius_rel * diagonal)) ||
            std::ranges::count_if(last.plan.cage.finer_at, halved) >= most_halvings)
            return;
        region.balls.push_back({place, ball_radius_rel * diagonal});
    };
    for (const measure::Condition& condition : last.verdict.conditions)
        if (!condition.met && condition.at) add(*condition.at);
    if (region.balls.empty()) return std::nullopt;
    for (const measure::Fold& fold : last.folds.by_face) add(fold.point);
    for (const geom::Vec3& place : last.misses) add(place);
    for (const auto* way : {&last.deviation.output_to_input, &last.deviation.input_to_output})
        for (const measure::DeviationPlace& place : way->worst)
            if (place.distance > nearly_missed * options.tolerance_mm) add(place.point);
    plan.cage.finer_at.push_back(std::move(region));
    return plan;
}

bool tried(const std::vector<Attempt>& attempts, CageKind kind) {
    return std::any_of(attempts.begin(), attempts.end(),
                       [&](const Attempt& a) { return a.kind == kind; });
}

/// Finer blocks of the field, once, where only the shape misses, as lines that lie badly do so in
/// finer ones too; then blocks along faces, or none where these miss too or there are none.
std::optional<AttemptPlan> after_field(const std::vector<Attempt>& attempts, const Attempt& best,
                                       const ConvertOptions& options) {
    const Attempt& last = attempts.back();
    AttemptPlan next{.cage = last.plan.cage};
    if (!last.finer_refused && last.plan.cage.fineness == 1.0 && misses_shape_only(best)) {
        next.cage.method = cage::Method::Aligned;
        next.cage.blocks = cage::BlockWay::Field;
        next.cage.fineness *= 2.0;
        return next;
    }
    const bool refused =
        tried(attempts, CageKind::Blocks) ||
        std::any_of(attempts.begin(), attempts.end(), [](auto& a) { return a.faces_refused; });
    if (refused && options.method != cage::Method::Auto) return std::nullopt;
    next.cage.method = options.method;
    next.cage.blocks = refused ? cage::BlockWay::None : cage::BlockWay::Faces;
    next.cage.fineness = 1.0;
    return next;
}

}  // namespace

bool AttemptPlan::same_cage(const AttemptPlan& other) const {
    return given == other.given && cage.method == other.cage.method &&
           cage.fineness == other.cage.fineness && cage.blocks == other.cage.blocks &&
           cage.finer_at == other.cage.finer_at;
}

std::optional<AttemptPlan> choose_next(const std::vector<Attempt>& attempts,
                                       const ConvertOptions& options, double diagonal) {
    if (attempts.empty()) {
        AttemptPlan first{.given = options.cage.has_value()};
        first.cage.method = options.method;
        first.cage.target_faces = options.target_faces;
        first.cage.tolerance_rel = options.tolerance_mm / diagonal;
        return first;
    }
    const Attempt& last = attempts.back();
    if (last.verdict.met()) return std::nullopt;
    if (const auto nearer = nearer_for_normals(last)) return nearer;
    if (options.cage) return std::nullopt;
    if (nearer_helps(last)) {
        AttemptPlan nearer = last.plan;
        nearer.fit_share *= 0.5;
        return nearer;
    }
    // The form of a cage's lines keeps faces from folding; where it keeps the fit from coming near,
    // it goes.
    if (last.kind == CageKind::Sections && last.plan.preserve_parametrisation) {
        AttemptPlan free = last.plan;
        free.preserve_parametrisation = false;
        return free;
    }
    const Attempt& best = best_of_last_cage(attempts);
    AttemptPlan finer{.cage = last.plan.cage};  // with the whole tolerance again
    finer.cage.fineness *= 2.0;
    AttemptPlan remeshed{.cage = last.plan.cage};
    remeshed.cage.method = cage::Method::Remesh;
    remeshed.cage.fineness = 1.0;
    const bool may_remesh = options.method == cage::Method::Auto;
    switch (last.kind) {
        case CageKind::Given: return std::nullopt;
        case CageKind::Sections:
            if (!last.finer_refused && worst_excess(best) <= far_off && gained(attempts))
                return finer;
            return may_remesh ? std::optional(remeshed) : std::nullopt;
        case CageKind::Field: return after_field(attempts, best, options);
        case CageKind::Blocks:
            // Where blocks miss, finer ones do too: faces that follow the shape are needed.
            if (may_remesh && !tried(attempts, CageKind::Field)) {
                AttemptPlan field{.cage = last.plan.cage};
                field.cage.blocks = cage::BlockWay::Field;
                return field;
            }
            if (may_remesh) return remeshed;
            return !last.finer_refused && gained(attempts) ? std::optional(finer) : std::nullopt;
        case CageKind::Remeshed: return finer_remeshed(best, options, diagonal);
    }
    return std::nullopt;
}

std::optional<std::size_t> choose_best(const std::vector<Attempt>& attempts, bool only_measured) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < attempts.size(); ++i) {
        if (only_measured && !attempts[i].measured) continue;
        if (!best || measure::better(attempts[i].verdict, attempts[*best].verdict)) best = i;
    }
    return best;
}

measure::Verdict assess(const Attempt& attempt, const Source& source, double tolerance_mm,
                        std::optional<double> normal_tolerance_rad) {
    measure::VerdictFigures figures = verdict_figures(attempt.shape, source.figures.closed);
    figures.tolerance_mm = tolerance_mm;
    figures.normal_tolerance_rad = normal_tolerance_rad;
    figures.diagonal_mm = source.input.diagonal;
    figures.stopped_by_time_limit = attempt.stopped_by_time_limit;
    figures.keeps_cage = attempt.keeps_cage;
    add_deviation(figures, attempt.deviation);
    // The fit looks at more points than the check: what it has found counts too.
    add_fit(figures, attempt.fit);
    // How often an open model is torn says little: its parts may be meant to be one.
    if (source.figures.closed) figures.bodies_of_input = source.bodies;
    if (source.is_body && source.figures.volume <= measure::film_volume(source.figures.area))
        figures.volume_mm3.reset();
    add_folds(figures, attempt.folds);
    return measure::assess(figures);
}

}  // namespace patchwright::convert
