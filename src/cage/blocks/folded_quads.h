// Quads of a cage that fold, and what becomes of a layout whose quads do.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <string>
#include <vector>

namespace patchwright::cage {

/// Sine of the angle at a quad's corner k as seen against a unit normal.
double corner_sine(const std::vector<geom::Vec3>& points, const std::vector<int>& face, int k,
                   const geom::Vec3& normal);

/// Half the cross product of the diagonals.
geom::Vec3 quad_area(const Blocks& blocks, std::size_t face);
geom::Vec3 quad_middle(const Blocks& blocks, std::size_t face);
/// Of a quad's four corners, as seen against its own normal.
double least_sine(const Blocks& blocks, std::size_t face);

/// Gives quads the names of the faces that they are on.
/// @param face_names  one a face of the model
/// @throw LayoutRefused when quads fold; for good when more than one in 25 do
Blocks checked(Blocks blocks, const geom::ModelSurface& reference,
               const std::vector<std::string>& face_names, Poll& poll);

}  // namespace patchwright::cage
