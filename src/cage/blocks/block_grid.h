// Quads of a block layout, placed on the model.
#pragma once

#include "cage/blocks.h"
#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Points of arcs by arc length and others between the points of the four sides; those on no
/// feature are evened out.
/// @param divisions   as divide_arcs() gives them
/// @param face_names  one a face of the model: groups of the quads
/// @throw LayoutRefused when quads fold
Blocks block_grid(const QuadLayout& layout, const Divisions& divisions,
                  const geom::ModelSurface& reference, const std::vector<std::string>& face_names,
                  Poll& poll);

}  // namespace patchwright::cage
