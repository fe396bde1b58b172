// Quads and triangles of a cage brought into shape.
#pragma once

#include "cage/poll.h"
#include "cage/remesh/merge_triangles.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Moves vertices on the model so that the faces around each become nearer to squares and regular
/// triangles. Vertices on feature curves slide along them, corners stay.
void relax_quads(const Polygons& polygons, geom::EditableMesh& mesh,
                 const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
