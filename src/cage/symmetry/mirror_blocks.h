// Blocks of a half and their mirror images.
#pragma once

#include "cage/blocks.h"
#include "cage/symmetry/half_surface.h"

namespace patchwright::cage {

/// Adds the mirror images of blocks of a half. Points on lines of the section are their own images,
/// and edges on these are smooth but where a sharp curve of the whole runs along them.
/// @param within_mm  as near to them as this
/// @return with numbers of the whole's curves
BlocksOnCurves with_mirror_image(BlocksOnCurves made, const HalfSurface& half, double within_mm,
                                 Poll& poll);

}  // namespace patchwright::cage
