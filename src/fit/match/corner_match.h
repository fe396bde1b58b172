// Which corners of the reference the corners of a cage belong to.
#pragma once

#include "geom/polyline.h"

#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/topology.h>

#include <map>
#include <vector>

namespace patchwright::fit {

using geom::Polyline;

/// The end of a chain of sharp edges at a vertex, as points from there on.
struct ChainEnd {
    geom::FeatureKind kind = geom::FeatureKind::Sharp;
    Polyline line;
};
using ChainEnds = std::map<mesh::VertexId, std::vector<ChainEnd>>;

/// Corners of the reference by vertex, one to one, with the least sum of squared distances; none
/// beyond `reach` or a quarter of the vertex' shortest chain. Where corners of the reference
/// nearly coincide, as on both sides of a slit, those are taken whose curves run along the vertex'
/// chains.
/// @param poll  called for each vertex; may throw
std::map<mesh::VertexId, int> match_corners(const std::vector<mesh::VertexId>& vertices,
                                            const geom::Points& points, const ChainEnds& chains,
                                            const geom::ReferenceSurface& reference, double reach,
                                            const std::function<void()>& poll);

}  // namespace patchwright::fit
