// Shared edges and vertices between the surfaces of charts.
#pragma once

#include "patch/layout.h"

#include <patchwright/patch/patch_set.h>

namespace patchwright::patch {

/// Fills vertices, edges and the sides of the patches, whose surfaces cover the charts with one
/// unit of parameter a face. Edges end where the corner of any chart is.
void connect(const mesh::Topology& t, const std::vector<Chart>& charts, PatchSet& set);

}  // namespace patchwright::patch
