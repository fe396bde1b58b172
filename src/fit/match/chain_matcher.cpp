#include "fit/match/chain_matcher.h"

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using geom::distance_to;
using geom::FeatureKind;
using geom::length_of;
using geom::part_of;
using geom::Vec3;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Points at which a piece of a curve is compared with a chain.
constexpr int piece_samples = 16;
// A way round a closed curve is taken in place of the shortest path when it is this much nearer to
// the chain (features_test: a chain follows its own way).
constexpr double detour_gain = 0.7;
// A chain reaches this share of its length, see FitOptions::feature_reach_rel.
constexpr double reach_of_length = 0.1;
// See ChainMatcher::length_cost(), in parts of the reach.
constexpr double length_cost_rel = 1e-3;

/// Factor of the distance to curves of another kind: creases may follow smooth edges where no sharp
/// one is a third as far (features_test: a crease goes on along smooth edges).
double kind_mismatch_penalty(FeatureKind chain, FeatureKind curve) {
    constexpr double smooth_for_sharp = 3.0;
    if (chain == curve) return 1.0;
    return chain == FeatureKind::Sharp && curve == FeatureKind::Smooth ? smooth_for_sharp
                                                                       : infinity;
}

}  // namespace

ChainMatcher::ChainMatcher(const geom::ReferenceSurface& reference,
                           const geom::CurveEnds& curve_ends, FeatureKind kind, double reach)
    : reference_(reference),
      features_(reference.features()),
      curve_ends_(curve_ends),
      kind_(kind),
      reach_(reach),
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
    const double length = length_of(line);
    move_ends(line, ends, stops);
    const bool loop = closed || (ends[0] >= 0 && ends[0] == ends[1]);
    ScoredPath best;
    if (!loop) best = scored_path(line, {0.0, 1.0}, stops);
    // The chain may follow a longer way round.
    const ScoredPath round = scored_path(line, {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0}, stops);
    if (round.score < detour_gain * best.score) best = round;
    const double allowed = std::max(reach_, reach_of_length * length);
    return mean_distance_to(best.path, line) <= allowed ? best.path : FeaturePath{};
}

double ChainMatcher::distance(int curve, const Polyline& line) const {
    const FeaturePiece piece{curve, {0.0, features_.curves[std::size_t(curve)].length}};
    return mean_distance(piece, line) + mean_distance_to({piece}, line);
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
            const double far = (point - end.point).norm();
            if (far >= distance) continue;
            distance = far;
            best = Stop{corner ? place : -1, point, true};
        }
    }
    return best;
}

ChainMatcher::ScoredPath ChainMatcher::scored_path(const Polyline& line,
                                                   const std::vector<double>& shares,
                                                   const std::array<Stop, 2>& ends) const {
    ScoredPath result;
    Stop from = ends[0];
    for (std::size_t i = 1; i < shares.size(); ++i) {
        const Polyline section = part_of(line, shares[i - 1], shares[i]);
        const auto to =
            i + 1 == shares.size() ? std::optional(ends[1]) : nearest_stop(section.back());
        const auto way = to ? shortest_path(section, from, *to) : std::nullopt;
        if (!way) return {};
        result.path.insert(result.path.end(), way->begin(), way->end());
        from = *to;
    }
    if (result.path.empty()) return {};
    double length = 0.0, sum = 0.0;
    for (const FeaturePiece& piece : result.path) {
        const double piece_length = piece.range.to - piece.range.from;
        length += piece_length;
        sum += piece_length * mean_distance(piece, line);
    }
    result.score = (length > 0.0 ? sum / length : 0.0) + mean_distance_to(result.path, line);
    return result;
}

double ChainMatcher::mean_distance(const FeaturePiece& piece, const Polyline& line) const {
    double sum = 0.0;
    for (int k = 0; k < piece_samples; ++k) {
        const double s =
            piece.range.from + (k + 0.5) / piece_samples * (piece.range.to - piece.range.from);
        sum += distance_to(line, reference_.point_on_curve(piece.curve, s).point);
    }
    return sum / piece_samples;
}

double ChainMatcher::mean_distance_to(const FeaturePath& path, const Polyline& line) const {
    if (path.empty()) return infinity;
    double sum = 0.0;
    for (const Vec3& p : line) sum += nearest_on_path(reference_, path, p).distance;
    return sum / double(line.size());
}

double ChainMatcher::length_cost() const { return length_cost_rel * reach_; }

std::vector<std::vector<ChainMatcher::Link>> ChainMatcher::links(const Stop& from,
                                                                 const Stop& to) const {
    std::vector<std::vector<Link>> result(curve_ends_.points.size() + 2);
    for (std::size_t c = 0; c < features_.curves.size(); ++c) {
        const geom::FeatureCurve& curve = features_.curves[c];
        const double penalty = kind_mismatch_penalty(kind_, curve.kind);
        if (std::isinf(penalty)) continue;
        std::vector<std::pair<double, int>> nodes;
        const auto [start, end] = curve_ends_.places[c];
        if (start >= 0) nodes.emplace_back(0.0, start + 2);
        for (const auto& [stop, node] : {std::pair(&from, 0), std::pair(&to, 1)}) {
            if (stop->corner >= 0) continue;
            const auto here = reference_.nearest_on_curve(int(c), stop->point);
            if (here.distance < coincidence_mm_) nodes.emplace_back(here.arc_length, node);
        }
        if (end >= 0) nodes.emplace_back(curve.length, end + 2);
        std::stable_sort(nodes.begin(), nodes.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        if (curve.closed && start < 0 && !nodes.empty()) {
            nodes.emplace_back(nodes.front().first + curve.length, nodes.front().second);
        }
        for (std::size_t i = 1; i < nodes.size(); ++i) {
            const FeaturePiece piece{int(c), {nodes[i - 1].first, nodes[i].first}};
            result[std::size_t(nodes[i - 1].second)].push_back({nodes[i].second, piece, penalty});
            result[std::size_t(nodes[i].second)].push_back({nodes[i - 1].second, piece, penalty});
        }
    }
    return result;
}

std::optional<FeaturePath> ChainMatcher::shortest_path(const Polyline& line, const Stop& from,
                                                       const Stop& to) const {
    const auto graph = links(from, to);
    const auto node = [](const Stop& stop, int other) {
        return std::size_t(stop.corner >= 0 ? stop.corner + 2 : other);
    };
    const std::size_t start = node(from, 0), goal = node(to, 1);
    std::vector<double> cost(graph.size(), infinity);
    std::vector<std::pair<std::size_t, FeaturePiece>> back(graph.size());
    std::vector<char> done(graph.size(), 0);
    cost[start] = 0.0;
    for (;;) {
        std::size_t at = graph.size();
        for (std::size_t n = 0; n < graph.size(); ++n) {
            if (done[n] == 0 && cost[n] < infinity && (at == graph.size() || cost[n] < cost[at]))
                at = n;
        }
        if (at == graph.size()) return std::nullopt;
        if (at == goal) break;
        done[at] = 1;
        for (const Link& link : graph[at]) {
            const auto next = std::size_t(link.to);
            if (done[next] != 0) continue;
            const double length = link.piece.range.to - link.piece.range.from;
            const double sum = cost[at] + link.penalty * length *
                                              (mean_distance(link.piece, line) + length_cost());
            if (sum >= cost[next]) continue;
            cost[next] = sum;
            back[next] = {at, link.piece};
        }
    }
    FeaturePath path;
    for (std::size_t n = goal; n != start; n = back[n].first) {
        const FeaturePiece& piece = back[n].second;
        if (piece.range.to > piece.range.from) path.push_back(piece);
    }
    std::reverse(path.begin(), path.end());
    return path;
}

}  // namespace patchwright::fit
