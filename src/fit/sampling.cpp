#include "fit/sampling.h"

#include <cmath>

namespace patchwright::fit {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;

subd::ParameterSet interior_grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) set.emplace_back((i + 0.5) / n, (j + 0.5) / n);
    }
    return set;
}

subd::ParameterSet closed_grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) set.emplace_back(double(i) / n, double(j) / n);
    }
    return set;
}

std::vector<subd::ParameterSet> side_sets(int n) {
    std::vector<subd::ParameterSet> sets(4);
    for (int k = 0; k < n; ++k) {
        const double t = (k + 0.5) / n;
        sets[0].emplace_back(t, 0.0);
        sets[1].emplace_back(1.0, t);
        sets[2].emplace_back(t, 1.0);
        sets[3].emplace_back(0.0, t);
    }
    return sets;
}

std::vector<subd::Site> face_sites(const Topology& topology) {
    std::vector<subd::Site> sites;
    for (const FaceId f : topology.faces()) {
        const int sectors = topology.size(f) == 4 ? 1 : topology.size(f);
        for (int s = 0; s < sectors; ++s) sites.push_back({f, s, 0});
    }
    return sites;
}

namespace {

/// Numbers of the chains of infinitely sharp edges, by edge; -1 for other edges.
std::vector<int> edge_chains(const Topology& topology, int& count) {
    std::vector<std::vector<EdgeId>> sharp(std::size_t(topology.vertex_count()));
    for (const EdgeId e : topology.edges()) {
        if (!std::isinf(topology.sharpness(e))) continue;
        sharp[topology.start(e).index()].push_back(e);
        sharp[topology.end(e).index()].push_back(e);
    }
    std::vector<int> chain(std::size_t(topology.edge_count()), -1);
    std::vector<EdgeId> pending;
    for (const EdgeId first : topology.edges()) {
        if (!std::isinf(topology.sharpness(first)) || chain[first.index()] >= 0) continue;
        pending.push_back(first);
        chain[first.index()] = count;
        while (!pending.empty()) {
            const EdgeId e = pending.back();
            pending.pop_back();
            for (const mesh::VertexId v : {topology.start(e), topology.end(e)}) {
                if (sharp[v.index()].size() != 2 || std::isinf(topology.sharpness(v))) continue;
                for (const EdgeId next : sharp[v.index()]) {
                    if (chain[next.index()] >= 0 ||
                        topology.is_boundary(next) != topology.is_boundary(e)) {
                        continue;
                    }
                    chain[next.index()] = count;
                    pending.push_back(next);
                }
            }
        }
        ++count;
    }
    return chain;
}

}  // namespace

CurveSampling curve_sites(const Topology& topology) {
    CurveSampling sampling;
    const std::vector<int> chain = edge_chains(topology, sampling.chain_count);
    for (const EdgeId e : topology.edges()) {
        if (!std::isinf(topology.sharpness(e))) continue;
        const CornerId c = topology.corner(e);
        const FaceId f = topology.face(c);
        const int n = topology.size(f);
        const int i = c.value - topology.corners(f)[0].value;
        if (n == 4) {
            sampling.sites.push_back({f, 0, i});
        } else {
            // The first half of the edge is side 0 of its start's sector, the rest side 3 of the
            // next.
            sampling.sites.push_back({f, i, 0});
            sampling.sites.push_back({f, (i + 1) % n, 3});
        }
        sampling.kinds.resize(sampling.sites.size(),
                              topology.is_boundary(e) ? CurveKind::Boundary : CurveKind::Crease);
        sampling.chains.resize(sampling.sites.size(), chain[e.index()]);
    }
    return sampling;
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
