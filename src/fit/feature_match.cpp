#include "fit/feature_match.h"

#include "fit/assignment.h"
#include "fit/corner_match.h"

#include <patchwright/geom/curve_ends.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace patchwright::fit {

namespace {

using geom::FeatureKind;
using geom::Features;
using geom::Points;
using geom::Vec3;
using mesh::VertexId;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int piece_samples = 16;
constexpr double same_rel = 1e-6;  // of the diagonal

/// Where a path begins or ends: a corner of the reference or a point of one of its curves.
struct Stop {
    int corner = -1;
    Vec3 point = Vec3::Zero();
    bool ends_curve = false;
};

/// An end of a chain without a corner, and how far it may go for the end of a curve.
struct LooseEnd {
    Vec3 point = Vec3::Zero();
    double reach = 0.0;
    bool dart = false;  ///< ends within the surface
};

struct Candidate {
    FeaturePath path;
    double score = infinity;
};

/// By how much more a curve of the reference counts as far from a chain of this kind: creases may
/// follow smooth edges where no sharp one is as near.
double dearness(FeatureKind chain, FeatureKind curve) {
    constexpr double of_smooth = 3.0;
    if (chain == curve) return 1.0;
    return chain == FeatureKind::Sharp && curve == FeatureKind::Smooth ? of_smooth : infinity;
}

class ChainMatcher {
  public:
    ChainMatcher(const geom::ReferenceSurface& reference, const geom::CurveEnds& curve_ends,
                 FeatureKind kind, double reach)
        : reference_(reference),
          features_(reference.features()),
          curve_ends_(curve_ends),
          kind_(kind),
          reach_(reach),
          same_mm_(same_rel * reference.bounds().diagonal()) {}

    /// @param line  of the chain; is moved with its ends
    /// @param ends  the corners of the reference that the chain's ends have, if any
    /// @param loose  ends that are to go to the end of a curve, if one is near
    FeaturePath match(Polyline& line, bool closed, std::array<int, 2> ends,
                      const std::array<LooseEnd, 2>& loose, std::array<Stop, 2>& stops) const {
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

    /// What a moved chain is off a whole curve: means of both ways.
    [[nodiscard]] double distance(int curve, const Polyline& line) const {
        const FeaturePiece piece{curve, {0.0, features_.curves[std::size_t(curve)].length}};
        return mean_distance(piece, line) + mean_distance_to({piece}, line);
    }

  private:
    /// The chain goes where its ends go.
    static void move_ends(Polyline& line, std::array<int, 2> ends,
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

    [[nodiscard]] std::optional<Stop> nearest_stop(const Vec3& q) const {
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

    /// The nearest place where a curve begins or ends, but for corners, as where a smooth edge
    /// begins at a sharp rim; for darts also corners where one ends within the surface.
    [[nodiscard]] std::optional<Stop> nearest_end(const LooseEnd& end) const {
        double distance = end.reach;
        std::optional<Stop> best;
        for (std::size_t c = 0; c < features_.curves.size(); ++c) {
            if (std::isinf(dearness(kind_, features_.curves[c].kind))) continue;
            for (const int place : curve_ends_.places[c]) {
                if (place < 0) continue;
                const bool corner = place < int(features_.corners.size());
                if (corner && !(end.dart && features_.corners[std::size_t(place)].kind ==
                                                geom::CornerKind::End))
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

    /// The path whose sections between these shares of the chain are the best for each.
    [[nodiscard]] Candidate candidate(const Polyline& line, const std::vector<double>& shares,
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

    /// From a piece to the chain.
    [[nodiscard]] double mean_distance(const FeaturePiece& piece, const Polyline& line) const {
        double sum = 0.0;
        for (int k = 0; k < piece_samples; ++k) {
            const double s =
                piece.range.from + (k + 0.5) / piece_samples * (piece.range.to - piece.range.from);
            sum += distance_to(line, reference_.point_on_curve(piece.curve, s).point);
        }
        return sum / piece_samples;
    }

    /// From the chain to a path.
    [[nodiscard]] double mean_distance_to(const FeaturePath& path, const Polyline& line) const {
        if (path.empty()) return infinity;
        double sum = 0.0;
        for (const Vec3& p : line) sum += nearest_on_path(reference_, path, p).distance;
        return sum / double(line.size());
    }

    /// What a way along curves costs for its length alone.
    [[nodiscard]] double little() const { return 1e-3 * reach_; }

    struct Link {
        int to;
        FeaturePiece piece;
        double dear;
    };

    /// The pieces of all curves of the kind between corners and these two stops, which are nodes
    /// 0 and 1; place p of CurveEnds is node p + 2. A stop may lie on several curves.
    [[nodiscard]] std::vector<std::vector<Link>> links(const Stop& from, const Stop& to) const {
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

    /// The way along curves whose distance from the chain, summed along the way, is least.
    [[nodiscard]] std::optional<FeaturePath> shortest_path(const Polyline& line, const Stop& from,
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
                if (done[n] == 0 && cost[n] < infinity &&
                    (at == graph.size() || cost[n] < cost[at]))
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

    const geom::ReferenceSurface& reference_;
    const Features& features_;
    const geom::CurveEnds& curve_ends_;
    FeatureKind kind_;
    double reach_;
    double same_mm_;
};

FeatureKind feature_kind(const Chain& chain) {
    return chain.kind == CurveKind::Crease ? FeatureKind::Sharp : FeatureKind::Free;
}

/// Chains between the same two corners, of which some were given the same curve though there are
/// others, get one each, with the least sum of distances.
void part_curves(const std::vector<Chain>& chains, const std::vector<std::array<int, 2>>& corners,
                 const std::vector<Polyline>& lines, const geom::ReferenceSurface& reference,
                 const geom::CurveEnds& curve_ends, double reach, std::vector<FeaturePath>& paths) {
    const Features& features = reference.features();
    using Key = std::pair<std::pair<int, int>, FeatureKind>;
    std::map<Key, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < chains.size(); ++i)
        if (paths[i].size() == 1 && corners[i][0] >= 0 && corners[i][1] >= 0)
            groups[{std::minmax(corners[i][0], corners[i][1]), feature_kind(chains[i])}].push_back(
                i);
    for (const auto& [key, group] : groups) {
        std::set<int> taken;
        for (const std::size_t i : group) taken.insert(paths[i].front().curve);
        if (taken.size() == group.size()) continue;
        std::vector<int> curves;
        for (std::size_t c = 0; c < features.curves.size(); ++c) {
            const geom::FeatureCurve& curve = features.curves[c];
            if (curve.kind == key.second &&
                std::pair<int, int>(std::minmax(curve.start_corner, curve.end_corner)) == key.first)
                curves.push_back(int(c));
        }
        const ChainMatcher matcher(reference, curve_ends, key.second, reach);
        Eigen::MatrixXd cost(Eigen::Index(group.size()), Eigen::Index(curves.size()));
        for (Eigen::Index i = 0; i < cost.rows(); ++i)
            for (Eigen::Index j = 0; j < cost.cols(); ++j)
                cost(i, j) = matcher.distance(curves[std::size_t(j)], lines[group[std::size_t(i)]]);
        const double dear = 1.0 + 2.0 * cost.sum();
        const auto assigned = assign(cost, Eigen::VectorXd::Constant(cost.rows(), dear));
        for (std::size_t i = 0; i < group.size(); ++i) {
            if (assigned[i] < 0) continue;
            const int curve = curves[std::size_t(assigned[i])];
            paths[group[i]] = {{curve, {0.0, features.curves[std::size_t(curve)].length}}};
        }
    }
}

/// The chain as points, with its ends where those have a fixed place.
Polyline chain_line(const Chain& chain, const Points& points, const Points& samples,
                    int samples_per_site, const std::vector<VertexId>& fixed) {
    const auto add_end = [&](Polyline& line, VertexId v) {
        if (!chain.closed && std::find(fixed.begin(), fixed.end(), v) != fixed.end())
            line.emplace_back(points.row(v.value).transpose());
    };
    Polyline line;
    add_end(line, chain.vertices.front());
    for (const auto& [site, backwards] : chain.sites) {
        for (int k = 0; k < samples_per_site; ++k) {
            const int row = site * samples_per_site + (backwards ? samples_per_site - 1 - k : k);
            line.emplace_back(samples.row(row).transpose());
        }
    }
    add_end(line, chain.vertices.back());
    return thinned(line);
}

}  // namespace

geom::FeaturePoint nearest_on_path(const geom::ReferenceSurface& reference, const FeaturePath& path,
                                   const Vec3& query) {
    geom::FeaturePoint best;
    best.distance = infinity;
    for (const FeaturePiece& piece : path) {
        auto hit = reference.nearest_on_curve(piece.curve, query, piece.range);
        if (hit.distance < best.distance) best = hit;
    }
    return best;
}

FeatureMatch match_features(const mesh::Topology& topology, const Points& points,
                            const CurveSampling& curves, const Points& samples,
                            int samples_per_site, const geom::ReferenceSurface& reference,
                            double reach) {
    const Features& features = reference.features();
    const auto fixed = corner_vertices(topology);
    std::vector<Polyline> lines;
    ChainEnds chain_ends;
    for (const Chain& chain : curves.chains) {
        lines.push_back(chain_line(chain, points, samples, samples_per_site, fixed));
        Polyline line = lines.back();
        chain_ends[chain.vertices.front()].push_back({feature_kind(chain), line});
        std::reverse(line.begin(), line.end());
        chain_ends[chain.vertices.back()].push_back({feature_kind(chain), std::move(line)});
    }
    const auto corners = match_corners(fixed, points, chain_ends, reference, reach);
    const geom::CurveEnds curve_ends =
        geom::curve_ends(features, same_rel * reference.bounds().diagonal());
    FeatureMatch result;
    std::vector<std::array<int, 2>> chain_corners;
    std::map<VertexId, Vec3> places;
    std::map<VertexId, bool> has_chain;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const Chain& chain = curves.chains[i];
        const std::array<VertexId, 2> ends{chain.vertices.front(), chain.vertices.back()};
        std::array<int, 2> end_corners{-1, -1};
        for (std::size_t k = 0; k < 2 && !chain.closed; ++k) {
            const auto corner = corners.find(ends[k]);
            if (corner != corners.end()) end_corners[k] = corner->second;
        }
        chain_corners.push_back(end_corners);
        const std::array<VertexId, 2> inner{chain.vertices[1],
                                            chain.vertices[chain.vertices.size() - 2]};
        std::array<LooseEnd, 2> loose;
        for (std::size_t k = 0; k < 2 && !chain.closed; ++k) {
            const Vec3 at = points.row(ends[k].value).transpose();
            const Vec3 before = points.row(inner[k].value).transpose();
            const bool dart = std::find(fixed.begin(), fixed.end(), ends[k]) == fixed.end();
            const bool joins = chain_ends[ends[k]].size() > 2;
            // Both ends of a chain are not to go to the same place.
            const double near = std::min((at - before).norm(), 0.5 * length_of(lines[i]));
            loose[k] = {at, joins ? reach : dart ? near : 0.0, dart};
        }
        std::array<Stop, 2> stops;
        result.paths.push_back(ChainMatcher(reference, curve_ends, feature_kind(chain), reach)
                                   .match(lines[i], chain.closed, end_corners, loose, stops));
        for (std::size_t k = 0; k < 2 && !chain.closed; ++k) {
            if (loose[k].dart) {
                if (!result.paths.back().empty() && stops[k].ends_curve)
                    result.darts.push_back({ends[k], int(i), stops[k].point});
                continue;
            }
            has_chain.try_emplace(ends[k], false);
            if (result.paths.back().empty()) continue;
            has_chain[ends[k]] = true;
            places.try_emplace(ends[k], stops[k].point);
        }
    }
    part_curves(curves.chains, chain_corners, lines, reference, curve_ends, reach, result.paths);
    for (const auto& [vertex, corner] : corners) {
        // A corner whose sharp edges belong to nothing is no corner of the reference.
        const auto chain = has_chain.find(vertex);
        if (chain != has_chain.end() && !chain->second) continue;
        places[vertex] = features.corners[std::size_t(corner)].point;
    }
    for (const auto& [vertex, point] : places) result.places.push_back({vertex, point});
    return result;
}

}  // namespace patchwright::fit
