// Quads from triangles.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

#include <string>

namespace patchwright::cage {

/// Pairs triangles to quads, the best first, never across features; merges those that find no
/// partner along strips of quads, tidies what is extraordinary, and relaxes the vertices on the
/// model. Few triangles stay. Sharp features become creases; corners where a feature turns become
/// corners.
/// @param mesh        its vertices are moved, and vertices are added
/// @param face_names  one a face of the model: groups of the blocks
Blocks quad_blocks(geom::EditableMesh& mesh, const geom::ModelSurface& reference,
                   const std::vector<std::string>& face_names, Poll& poll);

}  // namespace patchwright::cage
