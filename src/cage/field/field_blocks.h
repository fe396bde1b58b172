// A cage of blocks between the lines of a cross field.
#pragma once

#include "cage/blocks/brep_cage.h"

namespace patchwright::cage {

/// Lines of a cross field part the surface between the borders into blocks.
/// @param body     of a fine mesh
/// @param borders  one entry a feature curve: whether it is a line of the cage; sharp and free ones
///                 are
/// @param scale    > 0: edges are longer by it
BodyBlocks field_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                        const geom::ModelSurface& reference,
                        const std::vector<std::string>& face_names, const CageOptions& options,
                        Poll& poll, double scale = 1.0);

}  // namespace patchwright::cage
