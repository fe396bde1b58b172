// Edges at corners where three or four quads between two features span more than 216 degrees.
#pragma once

#include "cage/blocks/shape_quads.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// Such corners are where the trailing edge of a fin meets a wing. Their quads are put at even
/// angles: the ends of their inner edges, no farther off than they are and than the edges of the
/// features, and the opposite corners of the quads. The limit surface may fold there otherwise
/// (decision 099). The next quads around them get good shapes again, see shape_quads().
/// @param points  on the model; moved
void even_corner_rings(const QuadsOnModel& quads, std::vector<geom::Vec3>& points,
                       const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
