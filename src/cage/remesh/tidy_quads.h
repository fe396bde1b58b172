// Fewer extraordinary vertices.
#pragma once

#include "cage/poll.h"
#include "cage/remesh/polygon_mesh.h"

namespace patchwright::cage {

/// Turns the edge between two quads, or collapses a quad along a diagonal, where vertices come
/// nearer to regular ones and quads stay good; where no single one does, two of them one after the
/// other. Nothing on features is moved.
/// Source: Tarini et al., Practical quad mesh simplification (2010), for the two operations.
/// @return whether anything was changed
bool tidy_quads(PolygonMesh& polygons, Poll& poll);

}  // namespace patchwright::cage
