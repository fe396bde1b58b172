// A cage of blocks along the faces of a model.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/geom/surface_mesh.h>

#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

/// One entry a feature curve: what is kept, and smooth ones where the curvature jumps, as at the
/// edges of fillets, part blocks; so do the seams of what has handles, as tori have.
/// @param kept  one entry a feature curve: lines of any cage, sharp and free ones among them
std::vector<char> block_borders(const geom::SurfaceMesh& surface,
                                const geom::ModelSurface& reference, const std::vector<char>& kept,
                                Poll& poll);

struct BodyBlocks {
    std::optional<Blocks> blocks;
    std::string refused;  ///< why there are none; empty: there are
};

/// Faces become blocks, smooth neighbours of the same curvature one; see brep_layout().
/// @param body     of a fine mesh
/// @param borders  see block_borders()
/// @param scale    > 0: edges are longer by it
BodyBlocks brep_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                       const geom::ModelSurface& reference,
                       const std::vector<std::string>& face_names, const CageOptions& options,
                       Poll& poll, double scale = 1.0);

}  // namespace patchwright::cage
