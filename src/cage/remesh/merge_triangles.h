// Triangles that pairing leaves, merged in twos along strips of quads.
#pragma once

#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <vector>

namespace patchwright::cage {

/// Faces of a cage with the vertices of a mesh.
struct Polygons {
    std::vector<std::vector<int>> corners;  ///< counter-clockwise; three or four each
    std::vector<int> faces;                 ///< of the model
};

/// Moves triangles through quads until they meet another one: a triangle and the quad beside it are
/// a pentagon, of which any three corners in a row may be the triangle. Of all ways the one that
/// makes the best quads is taken, none across a feature.
void merge_triangles(Polygons& polygons, const geom::EditableMesh& mesh, Poll& poll);

}  // namespace patchwright::cage
