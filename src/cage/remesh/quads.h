// Quads from triangles.
#pragma once

#include "cage/blocks.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/features.h>

#include <string>

namespace patchwright::cage {

/// Pairs triangles to quads, the best first, never across features; triangles that find no partner
/// stay. Sharp features become creases; corners where a feature turns become corners.
/// @param face_names  one a face of the model: groups of the blocks
Blocks quad_blocks(const geom::EditableMesh& mesh, const geom::Features& features,
                   const std::vector<std::string>& face_names);

}  // namespace patchwright::cage
