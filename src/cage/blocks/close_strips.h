// Narrow strips of surface become lines.
#pragma once

#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Closes strips between features that are nearer to each other than `width_mm` all along, as those
/// of blunt trailing edges are. What stays is the border of the surface, else the longer feature,
/// of one that comes back beside itself its first half; where it turns back that line ends within
/// the surface. A side with vertices nearer to each other than the width may become one chord.
/// Strips between parallel sides stay, as the rim of a plate, and so does what cannot be closed
/// all along.
/// @return how many strips were closed
int close_strips(geom::EditableMesh& mesh, const geom::ModelSurface& reference, double width_mm,
                 Poll& poll);

}  // namespace patchwright::cage
