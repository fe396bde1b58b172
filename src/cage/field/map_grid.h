// Quads along the whole coordinates of a block map.
#pragma once

#include "cage/blocks.h"
#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/field/size_metric.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <string>
#include <vector>

namespace patchwright::cage {

/// Points by a BlockMap, then moved so that quads get good shapes (shape_quads()), with even angles
/// at corners of wide sectors (even_corner_rings()); at wide corners of two quads their chords are
/// halved (divide_at_wide_corners()).
/// @param divisions   such that least_apart() is empty, without insertions
/// @param face_names  one a face of the model: groups of the quads
/// @param allowed_mm  how far the limit surface may go beyond corners of two quads
/// @pre every block is a whole piece
/// @throw LayoutRefused when quads fold or share two edges
Blocks map_grid(const QuadLayout& layout, const Divisions& divisions, const SizeMetric& metric,
                const geom::ModelSurface& reference, const std::vector<std::string>& face_names,
                double allowed_mm, Poll& poll);

}  // namespace patchwright::cage
