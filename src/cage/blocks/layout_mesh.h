// Triangles that a layout's lines are drawn on.
#pragma once

#include "cage/poll.h"
#include "cage/sections/sections.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// Of the tolerance: strips between features that are narrower become lines of a layout. The rest
/// is for the fit beside them.
inline constexpr double closed_share = 0.75;

/// Even triangles of a body, with several vertices on each feature however short it is.
/// @param body           of a fine mesh
/// @param borders        one entry a feature curve: whether it is a line of the cage
/// @param closed_strips  how many strips became lines
geom::EditableMesh layout_mesh(const SurfaceBody& body, const std::vector<char>& borders,
                               double tolerance_rel, const geom::ModelSurface& reference,
                               Poll& poll, int& closed_strips);

}  // namespace patchwright::cage
