// Triangles that pairing leaves, merged in twos along strips of quads.
#pragma once

#include "cage/poll.h"
#include "cage/remesh/polygon_mesh.h"

namespace patchwright::cage {

/// Moves triangles through quads until they meet another one: a triangle and the quad beside it are
/// a pentagon, of which any three corners in a row may be the triangle. Of all ways the one that
/// makes the best quads is taken, none across a feature.
/// @return whether any were merged
bool merge_triangles(PolygonMesh& polygons, Poll& poll);

}  // namespace patchwright::cage
