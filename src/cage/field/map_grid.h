// Quads along the whole coordinates of a block map.
#pragma once

#include "cage/blocks.h"
#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/field/size_metric.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Points by a BlockMap, then moved so that quads get good shapes (shape_quads()), with even angles
/// at corners of wide sectors (even_corner_rings()).
/// @param divisions  such that least_apart() is empty, without insertions
/// @pre every block is a whole piece
/// @throw LayoutRefused when quads share two edges
BlocksOnCurves map_grid(const QuadLayout& layout, const Divisions& divisions,
                        const SizeMetric& metric, const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
