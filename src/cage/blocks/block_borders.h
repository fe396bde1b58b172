// Curves of a model that part blocks along its faces.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>
#include <patchwright/geom/surface_mesh.h>

#include <vector>

namespace patchwright::cage {

/// One entry a feature curve: what is kept, and smooth ones where the curvature jumps, as at the
/// edges of fillets, part blocks; so do the seams of what has handles, as tori have.
/// @param kept  one entry a feature curve: lines of any cage, sharp and free ones among them
std::vector<char> block_borders(const geom::SurfaceMesh& surface,
                                const geom::ModelSurface& reference, const std::vector<char>& kept,
                                Poll& poll);

}  // namespace patchwright::cage
