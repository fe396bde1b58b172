// Shared edges and vertices between the surfaces of charts.
#pragma once

#include "patch/layout.h"

#include <patchwright/patch/patch_set.h>

namespace patchwright::patch {

/// Fills vertices, edges and the sides of the patches, whose surfaces cover the charts with one
/// unit of parameter a face. Edges end where the corner of any chart is.
/// @param at_vertex  per vertex of the mesh how surfaces around it meet beside sharp edges
void connect(const mesh::Topology& t, const std::vector<Chart>& charts,
             const std::vector<EdgeContinuity>& at_vertex, PatchSet& set);

}  // namespace patchwright::patch
