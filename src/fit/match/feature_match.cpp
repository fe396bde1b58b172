#include "fit/match/feature_match.h"

#include "fit/match/assignment.h"
#include "fit/match/chain_matcher.h"
#include "fit/match/corner_match.h"

#include <patchwright/geom/curve_ends.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

namespace patchwright::fit {

namespace {

using geom::FeatureKind;
using geom::Features;
using geom::Points;
using geom::Vec3;
using mesh::VertexId;

constexpr double infinity = std::numeric_limits<double>::infinity();

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
