// Cages of blocks of one body: between the lines of a cross field, or along the model's faces.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/cage/make_cage.h>

#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

struct BodyBlocks {
    std::optional<Blocks> blocks;
    std::string refused;    ///< why there are none; empty: there are
    int closed_strips = 0;  ///< narrower than the tolerance: they became lines, see close_strips()
};

/// Lines of a cross field part the surface between the borders into blocks.
/// @param body     of a fine mesh
/// @param borders  one entry a feature curve: whether it is a line of the cage; sharp and free ones
///                 are
/// @param scale    > 0: edges are longer by it
BodyBlocks field_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                        const geom::ModelSurface& reference,
                        const std::vector<std::string>& face_names, const CageOptions& options,
                        Poll& poll, double scale = 1.0);

/// Faces become blocks, smooth neighbours of the same curvature one; see brep_layout().
/// @param borders  see block_borders()
/// Others as field_blocks().
BodyBlocks face_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                       const geom::ModelSurface& reference,
                       const std::vector<std::string>& face_names, const CageOptions& options,
                       Poll& poll, double scale = 1.0);

}  // namespace patchwright::cage
