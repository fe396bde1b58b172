// Four-sided blocks from the faces of a model.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/piece_mesh.h"
#include "cage/poll.h"

namespace patchwright::cage {

/// Cuts what the features of a mesh bound into discs with four corners, or three, five, two or
/// none, which then are parted into blocks.
/// @param mesh   even triangles, finer than the blocks are to be; changed
/// @param lines  of a cross field, drawn in the mesh: only what they leave without a template is
///               cut; none: all is
/// @throw LayoutRefused
QuadLayout brep_layout(geom::EditableMesh& mesh, const geom::ModelSurface& reference, Poll& poll,
                       const FieldLines* lines = nullptr);

}  // namespace patchwright::cage
