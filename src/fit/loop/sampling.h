// The points of the limit surface that a fit samples.
#pragma once

#include "measure/limit_sites.h"

#include <patchwright/mesh/topology.h>
#include <patchwright/subd/limit_operator.h>

#include <utility>
#include <vector>

namespace patchwright::fit {

/// Kinds of curves whose samples belong to features of the reference.
enum class CurveKind { Crease, Boundary };

/// A maximal run of crease or of boundary edges without a corner of the cage inside.
struct EdgeChain {
    CurveKind kind = CurveKind::Crease;
    bool closed = false;
    /// Along the chain; one more than edges, or as many when it is closed.
    std::vector<mesh::VertexId> vertices;
    /// Along the chain: number among CurveSampling::sites, and whether its samples run backwards.
    std::vector<std::pair<int, bool>> sites;
};

struct CurveSampling {
    std::vector<subd::Site> sites;
    std::vector<int> chain_of_site;
    std::vector<EdgeChain> chains;
};

using measure::closed_grid;
using measure::face_sites;
using measure::interior_grid;

/// Set i samples side i of the square (v = 0, u = 1, v = 1, u = 0) at (k + 1/2) / n.
std::vector<subd::ParameterSet> side_sets(int n);

/// The same at k / n, with both ends.
std::vector<subd::ParameterSet> closed_side_sets(int n);

/// Every infinitely sharp crease and every boundary edge once, chain by chain, for use with
/// side_sets().
CurveSampling curve_sites(const mesh::Topology& topology);

/// Sets of one corner of the square each: (0, 0), (1, 0), (1, 1), (0, 1).
std::vector<subd::ParameterSet> corner_sets();

/// The site of a vertex for use with corner_sets().
subd::Site vertex_site(const mesh::Topology& topology, mesh::VertexId v);

/// Vertices with a fixed limit point: infinitely sharp ones and ends of three or more sharp edges.
std::vector<mesh::VertexId> corner_vertices(const mesh::Topology& topology);

}  // namespace patchwright::fit
