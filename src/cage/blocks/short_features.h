// Room on short features for the lines of a layout.
#pragma once

#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Gives features that are one side long some vertices.
void divide_short_features(geom::EditableMesh& mesh, const geom::ModelSurface& reference);

}  // namespace patchwright::cage
