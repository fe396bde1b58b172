// Where different surfaces of a list cross each other.
#pragma once

#include "measure/bezier_piece.h"

#include <patchwright/measure/self_intersection.h>

#include <vector>

namespace patchwright::measure {

/// One crossing of each pair of surfaces that has any, in the order of the pairs. Surfaces may meet
/// along their sides, and reach into each other by less than the resolution.
/// @param grids  of the surfaces
/// @throw Cancelled when `progress` says stop
std::vector<SelfIntersection> find_crossings(const std::vector<geom::BsplineSurface>& surfaces,
                                             const std::vector<const BezierGrid*>& grids,
                                             double resolution_mm, const base::Progress& progress);

}  // namespace patchwright::measure
