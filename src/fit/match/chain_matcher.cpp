#include "fit/match/chain_matcher.h"

#include "fit/match/curve_walk.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using base::infinity;
using geom::distance_to;
using geom::FeatureKind;
using geom::length_of;
using geom::Vec3;

namespace {

// Points at which a curve is compared with a chain.
constexpr int curve_samples = 16;
// A chain reaches this share of its length, see FitOptions::feature_reach_rel.
constexpr double reach_of_length = 0.1;
// See ChainMatcher::length_cost(), in parts of the reach.
constexpr double length_cost_rel = 1e-3;

}  // namespace

// Creases may follow smooth edges where no sharp one is a third as far (features_test: a crease
// goes on along smooth edges).
double kind_mismatch_penalty(FeatureKind chain, FeatureKind curve) {
    constexpr double smooth_for_sharp = 3.0;
    if (chain == curve) return 1.0;
    return chain == FeatureKind::Sharp && curve == FeatureKind::Smooth ? smooth_for_sharp
                                                                       : infinity;
}

ChainMatcher::ChainMatcher(const geom::ReferenceSurface& reference,
                           const geom::CurveEnds& curve_ends, FeatureKind kind, double reach,
                           const std::function<void()>& poll)
    : reference_(reference),
      features_(reference.features()),
      curve_ends_(curve_ends),
      kind_(kind),
      reach_(reach),
      poll_(poll),
      coincidence_mm_(coincidence_rel * reference.bounds().diagonal()) {}

FeaturePath ChainMatcher::match(Polyline& line, bool closed, std::array<int, 2> ends,
                                const std::array<LooseEnd, 2>& loose,
                                std::array<Stop, 2>& stops) const {
    if (closed) line.push_back(line.front());
    const std::array<Vec3, 2> at{line.front(), line.back()};
    for (std::size_t k = 0; k < 2; ++k) {
        std::optional<Stop> stop;
        if (ends[k] >= 0) {
            const Vec3 point = features_.corners[std::size_t(ends[k])].point;
            stop = Stop{ends[k], point};
        } else {
            stop = nearest_end(loose[k]);
            if (!stop) stop = nearest_stop(at[k]);
        }
        if (!stop) return {};
        stops[k] = *stop;
    }
    const double allowed = std::max(reach_, reach_of_length * length_of(line));
    move_ends(line, ends, stops);
    CurveWalk walk(reference_, curve_ends_,
                   {.kind = kind_,
                    .length_cost_mm = length_cost(),
                    .coincidence_mm = coincidence_mm_,
                    .reach_mm = allowed,
                    .poll = poll_},
                   line);
    FeaturePath path = closed ? walk.round() : walk.between(stops);
    return walk.mean_distance() <= allowed && is_bent(path) ? path : FeaturePath{};
}

bool ChainMatcher::is_bent(const FeaturePath& path) const {
    // Smooth edges that bend nowhere, as those of a fillet, are no path for a crease.
    return std::any_of(path.begin(), path.end(), [&](const FeaturePiece& piece) {
        const geom::FeatureCurve& curve = features_.curves[std::size_t(piece.curve)];
        return curve.kind == kind_ || curve.greatest_angle_rad > geom::least_bend_rad;
    });
}

double ChainMatcher::distance(int curve, const Polyline& line) const {
    const double length = features_.curves[std::size_t(curve)].length;
    double of_line = 0.0, of_curve = 0.0;
    for (const Vec3& p : line) of_line += reference_.nearest_on_curve(curve, p).distance;
    for (int k = 0; k < curve_samples; ++k) {
        const double s = (k + 0.5) / curve_samples * length;
        of_curve += distance_to(line, reference_.point_on_curve(curve, s).point);
    }
    return of_line / double(line.size()) + of_curve / curve_samples;
}

void ChainMatcher::move_ends(Polyline& line, std::array<int, 2> ends,
                             const std::array<Stop, 2>& stops) {
    const Vec3 first = ends[0] >= 0 ? Vec3(stops[0].point - line.front()) : Vec3::Zero();
    const Vec3 last = ends[1] >= 0 ? Vec3(stops[1].point - line.back()) : Vec3::Zero();
    const double whole = length_of(line);
    if (!(whole > 0.0)) return;
    double passed = 0.0;
    Vec3 before = line.front();
    for (Vec3& p : line) {
        passed += (p - before).norm();
        before = p;
        p += (1.0 - passed / whole) * first + passed / whole * last;
    }
}

std::optional<Stop> ChainMatcher::nearest_stop(const Vec3& q) const {
    std::optional<Stop> best;
    double distance = infinity;
    for (std::size_t c = 0; c < features_.curves.size(); ++c) {
        const double penalty = kind_mismatch_penalty(kind_, features_.curves[c].kind);
        if (std::isinf(penalty)) continue;
        const auto hit = reference_.nearest_on_curve(int(c), q);
        const double far = penalty * (hit.distance + length_cost());
        if (far >= distance) continue;
        distance = far;
        best = Stop{-1, hit.point};
    }
    return best;
}

std::optional<Stop> ChainMatcher::nearest_end(const LooseEnd& end) const {
    double distance = end.reach;
    std::optional<Stop> best;
    for (std::size_t c = 0; c < features_.curves.size(); ++c) {
        if (std::isinf(kind_mismatch_penalty(kind_, features_.curves[c].kind))) continue;
        for (const int place : curve_ends_.places[c]) {
            if (place < 0) continue;
            const bool corner = place < int(features_.corners.size());
            if (corner &&
                !(end.dart && features_.corners[std::size_t(place)].kind == geom::CornerKind::End))
                continue;
            const Vec3& point = curve_ends_.points[std::size_t(place)];
            const double far = std::min((point - end.control).norm(), (point - end.limit).norm());
            if (far >= distance) continue;
            distance = far;
            best = Stop{corner ? place : -1, point, true};
        }
    }
    return best;
}

double ChainMatcher::length_cost() const { return length_cost_rel * reach_; }

}  // namespace patchwright::fit
