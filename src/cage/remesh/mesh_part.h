// One body of a model's triangles by itself.
#pragma once

#include "cage/sections/sections.h"

namespace patchwright::cage {

/// @param kept  one a feature curve of the model: whether its sides stay features
geom::SurfaceMesh part_of(const SurfaceBody& body, const std::vector<char>& kept);

}  // namespace patchwright::cage
