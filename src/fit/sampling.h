// Which points of the limit surface a fit looks at.
#pragma once

#include <patchwright/mesh/topology.h>
#include <patchwright/subd/limit_operator.h>

#include <vector>

namespace patchwright::fit {

/// Kinds of curves whose samples belong to features of the reference.
enum class CurveKind { Crease, Boundary };

struct CurveSampling {
    std::vector<subd::Site> sites;
    std::vector<CurveKind> kinds;  ///< one a site
    /// One a site: which run of edges of one kind without a corner inside it belongs to, from 0.
    std::vector<int> chains;
    int chain_count = 0;
};

/// Parameters ((i + 1/2) / n, (j + 1/2) / n).
subd::ParameterSet interior_grid(int n);

/// The whole face including its border: (i / n, j / n), i and j from 0 to n.
subd::ParameterSet closed_grid(int n);

/// Set i samples side i of the square (v = 0, u = 1, v = 1, u = 0) at (k + 1/2) / n.
std::vector<subd::ParameterSet> side_sets(int n);

/// Every face, each sector of faces that are no quads; all use set 0.
std::vector<subd::Site> face_sites(const mesh::Topology& topology);

/// Every infinitely sharp crease and every boundary edge once, for use with side_sets().
CurveSampling curve_sites(const mesh::Topology& topology);

/// Vertices with a fixed limit point: infinitely sharp ones and ends of three or more sharp edges.
std::vector<mesh::VertexId> corner_vertices(const mesh::Topology& topology);

}  // namespace patchwright::fit
