// Narrow strips of surface become lines.
#pragma once

#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Closes strips between features that are nearer to each other than `width_mm` all along, as those
/// of blunt trailing edges are: what one feature has beyond the other goes to the longer one, of
/// one that comes back beside itself to its first half. Where it turns back the line that stays
/// ends within the surface.
/// @return how many strips were closed
int close_strips(geom::EditableMesh& mesh, const geom::ModelSurface& reference, double width_mm,
                 Poll& poll);

}  // namespace patchwright::cage
