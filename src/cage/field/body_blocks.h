// Cages of blocks of one body: between the lines of a cross field, or along the model's faces.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/sections.h"
#include "cage/symmetry/half_surface.h"

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

/// What blocks are made of.
struct BlockSource {
    const SurfaceBody& body;  ///< of a fine mesh of the reference
    const geom::ModelSurface& reference;
    const std::vector<std::string>& face_names;  ///< one a face of the reference: names of groups
    /// The reference where it is a half: the blocks get their mirror images.
    const HalfSurface* half = nullptr;
};

/// Lines of a cross field part the surface between the borders into blocks.
/// @param borders  one entry a feature curve of the reference: whether it is a line of the cage;
///                 sharp and free ones are
/// @param scale    > 0: edges are longer by it
BodyBlocks field_blocks(const BlockSource& source, const std::vector<char>& borders,
                        const CageOptions& options, Poll& poll, double scale = 1.0);

/// Faces become blocks, smooth neighbours of the same curvature one; see brep_layout().
/// @param borders  see block_borders()
/// Others as field_blocks().
BodyBlocks face_blocks(const BlockSource& source, const std::vector<char>& borders,
                       const CageOptions& options, Poll& poll, double scale = 1.0);

}  // namespace patchwright::cage
