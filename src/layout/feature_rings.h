// Closed chains of feature curves.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::layout {

/// The curves of a closed chain through a sharp curve, itself first, then on from its end: at each
/// place the sharp or smooth curve that leads straight on. Empty when there is none.
std::vector<int> ring_through(int curve, const geom::ModelSurface& reference);

}  // namespace patchwright::layout
