// Edges at corners where three or four quads between two features span more than 216 degrees.
#pragma once

#include "cage/blocks/shape_quads.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// Such corners are where the trailing edge of a fin meets a wing. The inner edges of their quads
/// are put at even angles, with lengths that are no longer than they are and than between those of
/// the features' edges. The limit surface may fold there otherwise (decision 099). Then these quads
/// and the next ones get good shapes again, see shape_quads(); ends of inner edges keep to the
/// edges' lines (decision 100).
/// @param points  on the model; moved
void even_corner_rings(const QuadsOnModel& quads, std::vector<geom::Vec3>& points,
                       const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
