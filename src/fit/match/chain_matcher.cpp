#include "fit/match/chain_matcher.h"

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using geom::FeatureKind;
using geom::Vec3;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int piece_samples = 16;

/// By how much more a curve of the reference counts as far from a chain of this kind: creases may
/// follow smooth edges where no sharp one is as near.
double dearness(FeatureKind chain, FeatureKind curve) {
    constexpr double of_smooth = 3.0;
    if (chain == curve) return 1.0;
    return chain == FeatureKind::Sharp && curve == FeatureKind::Smooth ? of_smooth : infinity;
}

}  // namespace

ChainMatcher::ChainMatcher(const geom::ReferenceSurface& reference,
                           const geom::CurveEnds& curve_ends, FeatureKind kind, double reach)
    : reference_(reference),
      features_(reference.features()),
      curve_ends_(curve_ends),
      kind_(kind),
      reach_(reach),
      same_mm_(same_rel * reference.bounds().diagonal()) {}

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
    Candidate best;
    if (!loop) best = candidate(line, {0.0, 1.0}, stops);
    // A way round may be what the chain follows, though there is a shorter one.
    const Candidate round = candidate(line, {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0}, stops);
    if (round.score < 0.7 * best.score) best = round;
    const double allowed = std::max(reach_, 0.1 * length);
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
        const double dear = dearness(kind_, features_.curves[c].kind);
        if (std::isinf(dear)) continue;
        const auto hit = reference_.nearest_on_curve(int(c), q);
        const double far = dear * (hit.distance + little());
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
        if (std::isinf(dearness(kind_, features_.curves[c].kind))) continue;
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

ChainMatcher::Candidate ChainMatcher::candidate(const Polyline& line,
                                                const std::vector<double>& shares,
                                                const std::array<Stop, 2>& ends) const {
    Candidate result;
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

double ChainMatcher::little() const { return 1e-3 * reach_; }

std::vector<std::vector<ChainMatcher::Link>> ChainMatcher::links(const Stop& from,
                                                                 const Stop& to) const {
    std::vector<std::vector<Link>> result(curve_ends_.points.size() + 2);
    for (std::size_t c = 0; c < features_.curves.size(); ++c) {
        const geom::FeatureCurve& curve = features_.curves[c];
        const double dear = dearness(kind_, curve.kind);
        if (std::isinf(dear)) continue;
        std::vector<std::pair<double, int>> nodes;
        const auto [start, end] = curve_ends_.places[c];
        if (start >= 0) nodes.emplace_back(0.0, start + 2);
        for (const auto& [stop, node] : {std::pair(&from, 0), std::pair(&to, 1)}) {
            if (stop->corner >= 0) continue;
            const auto here = reference_.nearest_on_curve(int(c), stop->point);
            if (here.distance < same_mm_) nodes.emplace_back(here.arc_length, node);
        }
        if (end >= 0) nodes.emplace_back(curve.length, end + 2);
        std::stable_sort(nodes.begin(), nodes.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        if (curve.closed && start < 0 && !nodes.empty()) {
            nodes.emplace_back(nodes.front().first + curve.length, nodes.front().second);
        }
        for (std::size_t i = 1; i < nodes.size(); ++i) {
            const FeaturePiece piece{int(c), {nodes[i - 1].first, nodes[i].first}};
            result[std::size_t(nodes[i - 1].second)].push_back({nodes[i].second, piece, dear});
            result[std::size_t(nodes[i].second)].push_back({nodes[i - 1].second, piece, dear});
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
            const double sum =
                cost[at] + link.dear * length * (mean_distance(link.piece, line) + little());
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
