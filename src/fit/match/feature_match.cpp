#include "fit/match/feature_match.h"

#include "fit/match/assignment.h"
#include "fit/match/chain_matcher.h"
#include "fit/match/corner_match.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/curve_ends.h>
#include <patchwright/subd/limit_mask.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

namespace patchwright::fit {

using base::infinity;

namespace {

using geom::FeatureKind;
using geom::Features;
using geom::length_of;
using geom::Points;
using geom::thinned;
using geom::Vec3;
using mesh::VertexId;

FeatureKind feature_kind(const EdgeChain& chain) {
    return chain.kind == CurveKind::Crease ? FeatureKind::Sharp : FeatureKind::Free;
}

/// Chains between the same two corners, of which some have the same curve though there are others,
/// get one each, with the least sum of distances.
void assign_parallel_curves(const std::vector<EdgeChain>& chains,
                            const std::vector<std::array<int, 2>>& corners,
                            const std::vector<Polyline>& lines,
                            const geom::ReferenceSurface& reference,
                            const geom::CurveEnds& curve_ends, double reach,
                            const std::function<void()>& poll, std::vector<FeaturePath>& paths) {
    const Features& features = reference.features();
    using Key = std::pair<std::pair<int, int>, FeatureKind>;
    std::map<Key, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < chains.size(); ++i)
        if (paths[i].size() == 1 && corners[i][0] >= 0 && corners[i][1] >= 0)
            groups[{std::minmax(corners[i][0], corners[i][1]), feature_kind(chains[i])}].push_back(
                i);
    for (const auto& [key, group] : groups) {
        if (key.first.first == key.first.second) continue;  // loops have their way already
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
        poll();
        const ChainMatcher matcher(reference, curve_ends, key.second, reach, poll);
        Eigen::MatrixXd cost(Eigen::Index(group.size()), Eigen::Index(curves.size()));
        for (Eigen::Index i = 0; i < cost.rows(); ++i)
            for (Eigen::Index j = 0; j < cost.cols(); ++j)
                cost(i, j) = matcher.distance(curves[std::size_t(j)], lines[group[std::size_t(i)]]);
        const double unassigned = 1.0 + 2.0 * cost.sum();  // more than any assignment
        const auto assigned =
            assign(cost, Eigen::VectorXd::Constant(cost.rows(), unassigned), poll);
        for (std::size_t i = 0; i < group.size(); ++i) {
            if (assigned[i] < 0) continue;
            const int number = curves[std::size_t(assigned[i])];
            const geom::FeatureCurve& curve = features.curves[std::size_t(number)];
            const bool reversed = curve.start_corner != corners[group[i]][0];
            paths[group[i]] = {{number, {0.0, curve.length}, reversed}};
        }
    }
}

/// The chain as points, with its ends where those have a fixed place.
Polyline chain_line(const EdgeChain& chain, const Points& points, const Points& samples,
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

namespace {

/// The ends of all chains by vertex, as lines from there on.
ChainEnds ends_of(const std::vector<EdgeChain>& chains, const std::vector<Polyline>& lines) {
    ChainEnds ends;
    for (std::size_t i = 0; i < chains.size(); ++i) {
        const FeatureKind kind = feature_kind(chains[i]);
        ends[chains[i].vertices.front()].push_back({kind, lines[i]});
        ends[chains[i].vertices.back()].push_back({kind, {lines[i].rbegin(), lines[i].rend()}});
    }
    return ends;
}

/// How far the ends of an open chain may go for the end of a curve.
std::array<LooseEnd, 2> loose_ends(const EdgeChain& chain, double length, const mesh::Cage& cage,
                                   const subd::LimitEvaluator& limit,
                                   const std::vector<VertexId>& fixed, const ChainEnds& chain_ends,
                                   double reach) {
    const std::size_t last = chain.vertices.size() - 1;
    std::array<LooseEnd, 2> loose;
    for (std::size_t k = 0; k < 2; ++k) {
        const VertexId end = chain.vertices[k == 0 ? 0 : last];
        const VertexId inner = chain.vertices[k == 0 ? 1 : last - 1];
        const Vec3 at = cage.points.row(end.value).transpose();
        const Vec3 before = cage.points.row(inner.value).transpose();
        const bool dart = std::find(fixed.begin(), fixed.end(), end) == fixed.end();
        const bool joins = chain_ends.at(end).size() > 2;
        // Both ends of a chain are not to go to the same place.
        const double near = std::min((at - before).norm(), 0.5 * length);
        loose[k] = {at, limit.position(cage.points, end), joins ? reach : dart ? near : 0.0, dart};
    }
    return loose;
}

/// Whether a curve turns by 45 degrees over a quarter of the edges on both sides of a vertex.
class TurnTest {
  public:
    TurnTest(const Points& points, const FeaturePath& path, const geom::ReferenceSurface& reference)
        : points_(points), path_(path), reference_(reference) {}

    [[nodiscard]] std::optional<Vec3> place(VertexId before, VertexId at, VertexId after) const {
        const Vec3 here = foot(points_.row(at.value), limit(before, at, after));
        const Vec3 in = here - on_path(here, before), out = on_path(here, after) - here;
        // Beside a corner all three may have the same foot point.
        if (in.norm() < least_way * edge(at, before) || out.norm() < least_way * edge(at, after))
            return std::nullopt;
        if (in.dot(out) > cosine * in.norm() * out.norm()) return std::nullopt;
        return here;
    }

  private:
    static constexpr double cosine = 0.7, share = 0.25, least_way = 0.5 * share;

    [[nodiscard]] double edge(VertexId a, VertexId b) const {
        return (points_.row(a.value) - points_.row(b.value)).norm();
    }
    [[nodiscard]] Eigen::RowVector3d limit(VertexId before, VertexId at, VertexId after) const {
        return (points_.row(before.value) + 4.0 * points_.row(at.value) +
                points_.row(after.value)) /
               6.0;
    }
    /// Control points of cages that are made are on the model; of fitted ones limit points are.
    [[nodiscard]] Vec3 foot(const Eigen::RowVector3d& one, const Eigen::RowVector3d& other) const {
        const geom::FeaturePoint p = nearest_on_path(reference_, path_, one.transpose()),
                                 q = nearest_on_path(reference_, path_, other.transpose());
        return p.distance < q.distance ? p.point : q.point;
    }
    /// Near the point that is this share of the way from a point to a vertex.
    [[nodiscard]] Vec3 on_path(const Vec3& from, VertexId to) const {
        const Vec3 at = (1.0 - share) * from + share * points_.row(to.value).transpose();
        return nearest_on_path(reference_, path_, at).point;
    }

    const Points& points_;
    const FeaturePath& path_;
    const geom::ReferenceSurface& reference_;
};

/// See FeatureMatch::turns.
std::vector<CurveTarget> turns_of(const mesh::Topology& topology, const Points& points,
                                  const std::vector<EdgeChain>& chains,
                                  const std::vector<FeaturePath>& paths,
                                  const geom::ReferenceSurface& reference) {
    std::vector<CurveTarget> turns;
    for (std::size_t c = 0; c < chains.size(); ++c) {
        if (paths[c].empty()) continue;
        const TurnTest test(points, paths[c], reference);
        const auto& line = chains[c].vertices;
        const std::size_t count = line.size();
        for (std::size_t i = 0; i < count; ++i) {
            if (!chains[c].closed && (i == 0 || i + 1 == count)) continue;
            const VertexId v = line[i];
            if (topology.valence(v) == (topology.is_boundary(v) ? 3 : 4)) continue;
            const auto place = test.place(line[(i + count - 1) % count], v, line[(i + 1) % count]);
            if (place) turns.push_back({v, int(c), *place});
        }
    }
    return turns;
}

}  // namespace

FeatureMatch match_features(const mesh::Cage& cage, const CurveSampling& curves,
                            const Points& samples, int samples_per_site,
                            const geom::ReferenceSurface& reference, double reach,
                            const std::function<void()>& poll) {
    const mesh::Topology& topology = *cage.topology;
    const Points& points = cage.points;
    const Features& features = reference.features();
    const auto fixed = corner_vertices(topology);
    std::vector<Polyline> lines;
    for (const EdgeChain& chain : curves.chains)
        lines.push_back(chain_line(chain, points, samples, samples_per_site, fixed));
    const ChainEnds chain_ends = ends_of(curves.chains, lines);
    const auto corners = match_corners(fixed, points, chain_ends, reference, reach, poll);
    const geom::CurveEnds curve_ends =
        geom::curve_ends(features, coincidence_rel * reference.bounds().diagonal());
    const subd::LimitEvaluator limit(cage.topology);
    FeatureMatch result;
    std::vector<std::array<int, 2>> chain_corners(lines.size(), {-1, -1});
    std::map<VertexId, Vec3> targets;
    std::map<VertexId, bool> has_path;  // any chain of a fixed vertex
    for (std::size_t i = 0; i < lines.size(); ++i) {
        poll();
        const EdgeChain& chain = curves.chains[i];
        const std::array<VertexId, 2> ends{chain.vertices.front(), chain.vertices.back()};
        std::array<LooseEnd, 2> loose;
        if (!chain.closed) {
            loose = loose_ends(chain, length_of(lines[i]), cage, limit, fixed, chain_ends, reach);
            for (std::size_t k = 0; k < 2; ++k) {
                const auto corner = corners.find(ends[k]);
                if (corner != corners.end()) chain_corners[i][k] = corner->second;
            }
        }
        std::array<Stop, 2> stops;
        result.paths.push_back(ChainMatcher(reference, curve_ends, feature_kind(chain), reach, poll)
                                   .match(lines[i], chain.closed, chain_corners[i], loose, stops));
        const bool found = !result.paths.back().empty();
        for (std::size_t k = 0; k < 2 && !chain.closed; ++k) {
            if (loose[k].dart) {
                if (found && stops[k].ends_curve)
                    result.darts.push_back({ends[k], int(i), stops[k].point});
                continue;
            }
            bool& any = has_path.try_emplace(ends[k], false).first->second;
            any = any || found;
            if (found) targets.try_emplace(ends[k], stops[k].point);
        }
    }
    assign_parallel_curves(curves.chains, chain_corners, lines, reference, curve_ends, reach, poll,
                           result.paths);
    for (const auto& [vertex, corner] : corners) {
        // A corner whose sharp edges belong to nothing is no corner of the reference.
        const auto path = has_path.find(vertex);
        if (path != has_path.end() && !path->second) continue;
        targets[vertex] = features.corners[std::size_t(corner)].point;
    }
    for (const auto& [vertex, point] : targets) result.corners.push_back({vertex, point});
    result.turns = turns_of(topology, points, curves.chains, result.paths, reference);
    return result;
}

}  // namespace patchwright::fit
