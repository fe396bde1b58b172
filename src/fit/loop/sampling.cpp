#include "fit/loop/sampling.h"

#include <cmath>

namespace patchwright::fit {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

namespace {

/// At (k + shift) / n, of each side of the square.
std::vector<subd::ParameterSet> sets_of_sides(int count, double shift, int n) {
    std::vector<subd::ParameterSet> sets(4);
    for (int k = 0; k < count; ++k) {
        const double t = (k + shift) / n;
        sets[0].emplace_back(t, 0.0);
        sets[1].emplace_back(1.0, t);
        sets[2].emplace_back(t, 1.0);
        sets[3].emplace_back(0.0, t);
    }
    return sets;
}

}  // namespace

std::vector<subd::ParameterSet> side_sets(int n) { return sets_of_sides(n, 0.5, n); }
std::vector<subd::ParameterSet> closed_side_sets(int n) { return sets_of_sides(n + 1, 0.0, n); }

namespace {

/// Walks the infinitely sharp edges, chain by chain.
class ChainWalk {
  public:
    explicit ChainWalk(const Topology& topology)
        : topology_(topology),
          sharp_(std::size_t(topology.vertex_count())),
          used_(std::size_t(topology.edge_count()), 0) {
        for (const EdgeId e : topology.edges()) {
            if (!std::isinf(topology.sharpness(e))) continue;
            sharp_[topology.start(e).index()].push_back(e);
            sharp_[topology.end(e).index()].push_back(e);
        }
    }

    CurveSampling sampling() {
        for (const VertexId v : topology_.vertices()) {
            if (goes_on(v)) continue;
            for (const EdgeId e : sharp_[v.index()]) {
                if (used_[e.index()] == 0) walk(v, e);
            }
        }
        for (const EdgeId e : topology_.edges()) {
            if (std::isinf(topology_.sharpness(e)) && used_[e.index()] == 0) {
                walk(topology_.start(e), e);
            }
        }
        return std::move(result_);
    }

  private:
    [[nodiscard]] bool goes_on(VertexId v) const {
        const auto& edges = sharp_[v.index()];
        return edges.size() == 2 && !std::isinf(topology_.sharpness(v)) &&
               topology_.is_boundary(edges[0]) == topology_.is_boundary(edges[1]);
    }

    void walk(VertexId from, EdgeId e) {
        const VertexId first = from;
        EdgeChain chain;
        chain.kind = topology_.is_boundary(e) ? CurveKind::Boundary : CurveKind::Crease;
        chain.vertices.push_back(from);
        for (;;) {
            used_[e.index()] = 1;
            add_sites(chain, e, from);
            from = topology_.start(e) == from ? topology_.end(e) : topology_.start(e);
            if (from == first && goes_on(first)) {
                chain.closed = true;
                break;
            }
            chain.vertices.push_back(from);
            if (!goes_on(from)) break;
            const auto& edges = sharp_[from.index()];
            e = edges[0] == e ? edges[1] : edges[0];
        }
        result_.chains.push_back(std::move(chain));
    }

    /// Sides 0 and 1 are sampled along the half-edge, sides 2 and 3 against it.
    void add_sites(EdgeChain& chain, EdgeId e, VertexId from) {
        const CornerId c = topology_.corner(e);
        const FaceId f = topology_.face(c);
        const int n = topology_.size(f);
        const int i = c.value - topology_.corners(f)[0].value;
        const bool along = topology_.vertex(c) == from;
        const auto add = [&](subd::Site site, bool backwards) {
            chain.sites.emplace_back(static_cast<int>(result_.sites.size()), backwards != !along);
            result_.sites.push_back(site);
            result_.chain_of_site.push_back(static_cast<int>(result_.chains.size()));
        };
        if (n == 4) {
            add({f, 0, i}, i >= 2);
            return;
        }
        // The first half of the edge is side 0 of its start's sector, the rest side 3 of the next.
        const subd::Site start{f, i, 0}, end{f, (i + 1) % n, 3};
        if (along) {
            add(start, false);
            add(end, true);
        } else {
            add(end, true);
            add(start, false);
        }
    }

    const Topology& topology_;
    std::vector<std::vector<EdgeId>> sharp_;  // by vertex
    std::vector<char> used_;                  // by edge
    CurveSampling result_;
};

}  // namespace

CurveSampling curve_sites(const Topology& topology) { return ChainWalk(topology).sampling(); }

std::vector<subd::ParameterSet> corner_sets() { return {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}}; }

subd::Site vertex_site(const Topology& topology, VertexId v) {
    const CornerId c = topology.corner(v);
    const FaceId f = topology.face(c);
    const int i = c.value - topology.corners(f)[0].value;
    return topology.size(f) == 4 ? subd::Site{f, 0, i} : subd::Site{f, i, 0};
}

std::vector<mesh::VertexId> corner_vertices(const Topology& topology) {
    std::vector<int> sharp_edges(std::size_t(topology.vertex_count()), 0);
    for (const EdgeId e : topology.edges()) {
        if (!std::isinf(topology.sharpness(e))) continue;
        ++sharp_edges[topology.start(e).index()];
        ++sharp_edges[topology.end(e).index()];
    }
    std::vector<mesh::VertexId> corners;
    for (const mesh::VertexId v : topology.vertices()) {
        if (std::isinf(topology.sharpness(v)) || sharp_edges[v.index()] > 2) corners.push_back(v);
    }
    return corners;
}

}  // namespace patchwright::fit
