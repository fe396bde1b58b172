// Points of a block layout spread evenly along the feature curves they lie on.
#pragma once

#include "cage/blocks/block_layout.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// Lines of blocks end on a curve where the blocks on its other side let them. What may move along
/// it, nodes that are no corners and points between them, is spread over the whole curve, by length
/// and turn, so that lines across do not run askew.
/// @param lines   one an arc: its points from start to end
/// @param points  moved along their curves
void spread_along_curves(const QuadLayout& layout, const std::vector<std::vector<int>>& lines,
                         const geom::ModelSurface& reference, std::vector<geom::Vec3>& points);

}  // namespace patchwright::cage
