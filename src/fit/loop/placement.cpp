#include "fit/loop/placement.h"

#include "fit/loop/projector.h"
#include "fit/match/path_alignment.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using mesh::EdgeId;
using mesh::Topology;
using mesh::VertexId;

/// The vertices of a chain move as the samples on both sides of them.
void add_moves(const EdgeChain& chain, const Points& samples, int n, const PathAlignment& alignment,
               Moves& moves) {
    geom::Polyline line;
    for (const auto& [site, backwards] : chain.sites)
        for (int k = 0; k < n; ++k)
            line.emplace_back(samples.row(site * n + (backwards ? n - 1 - k : k)).transpose());
    const auto targets = alignment.targets(line);
    const std::size_t edges = chain.vertices.size() - (chain.closed ? 0 : 1);
    const std::size_t per_edge = line.size() / edges;
    for (std::size_t v = 0; v < chain.vertices.size(); ++v) {
        const std::size_t after = v * per_edge, count = line.size();
        Vec3 sum = Vec3::Zero();
        int sides = 0;
        for (const std::size_t i : {after, (after + count - 1) % count}) {
            const bool beyond = !chain.closed && (v == 0 ? i != after : i >= count);
            if (beyond) continue;
            sum += targets[i].point - line[i];
            ++sides;
        }
        moves.try_emplace(chain.vertices[v], sum / std::max(sides, 1));
    }
}

Moves moves_of_chains(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                      const FitOptions& options) {
    const int n = options.solver.samples_per_edge;
    const CurveSampling curves = curve_sites(*cage.topology);
    const Points samples = curve_points(cage, curves, n);
    const FeatureMatch match = match_cage(cage, curves, samples, reference, options);
    Moves moves;
    for (const VertexTarget& corner : match.corners)
        moves[corner.vertex] = corner.point - cage.points.row(corner.vertex.value).transpose();
    for (std::size_t c = 0; c < curves.chains.size(); ++c) {
        const EdgeChain& chain = curves.chains[c];
        if (match.paths[c].empty()) continue;
        const PathAlignment alignment(reference, match.paths[c], chain.closed,
                                      chain.sites.size() * std::size_t(n));
        add_moves(chain, samples, n, alignment, moves);
    }
    return moves;
}

/// Whether a vertex is to move farther than an edge of its chain is long.
bool are_far(const mesh::Cage& cage, const Moves& moves) {
    const Topology& topology = *cage.topology;
    for (const EdgeId e : topology.edges()) {
        const auto a = moves.find(topology.start(e)), b = moves.find(topology.end(e));
        if (a == moves.end() || b == moves.end()) continue;
        const double length =
            (cage.points.row(a->first.value) - cage.points.row(b->first.value)).norm();
        if (std::min(a->second.norm(), b->second.norm()) > length) return true;
    }
    return false;
}

}  // namespace

std::optional<Points> carried_along(const Topology& topology, const Points& points,
                                    const Moves& known, double fading) {
    const int count = topology.vertex_count();
    std::vector<Eigen::Triplet<double>> entries;
    Points right = Points::Zero(count, 3);
    std::vector<double> diagonal(std::size_t(count), 0.0);
    for (const EdgeId e : topology.edges()) {
        const std::array<VertexId, 2> ends{topology.start(e), topology.end(e)};
        const double length = (points.row(ends[0].value) - points.row(ends[1].value)).norm();
        if (!(length > 0.0)) continue;
        for (std::size_t k = 0; k < 2; ++k) {
            const VertexId v = ends[k], w = ends[1 - k];
            diagonal[v.index()] += (1.0 + fading) / length;
            if (known.contains(v)) continue;
            if (const auto found = known.find(w); found != known.end())
                right.row(v.value) += found->second.transpose() / length;
            else
                entries.emplace_back(v.value, w.value, -1.0 / length);
        }
    }
    for (const auto& [v, move] : known) {
        diagonal[v.index()] = 1.0;
        right.row(v.value) = move.transpose();
    }
    for (int v = 0; v < count; ++v) entries.emplace_back(v, v, diagonal[std::size_t(v)]);
    Eigen::SparseMatrix<double> membrane(count, count);
    membrane.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(membrane);
    if (solver.info() != Eigen::Success) return std::nullopt;
    Points displacements = solver.solve(right);
    if (!displacements.allFinite()) return std::nullopt;
    return displacements;
}

mesh::Cage placed(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const FitOptions& options) {
    const Topology& topology = *cage.topology;
    Moves moves = moves_of_chains(cage, reference, options);
    if (!are_far(cage, moves)) return cage;
    for (const VertexId v : topology.vertices())
        if (topology.is_pinned(v)) moves[v] = Vec3::Zero();
    // A part without a chain has nothing to go by.
    const auto displacements = carried_along(topology, cage.points, moves, 0.0);
    if (!displacements) return cage;
    mesh::Cage result = cage;
    result.points += *displacements;
    return result;
}

}  // namespace patchwright::fit
