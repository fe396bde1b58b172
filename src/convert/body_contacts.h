// Where bodies of a model meet each other.
#pragma once

#include <patchwright/convert/shape.h>
#include <patchwright/geom/model_surface.h>

#include <memory>
#include <vector>

namespace patchwright::convert {

using BodySurfaces = std::vector<std::shared_ptr<const geom::ModelSurface>>;

/// Whether two bodies cross or touch where the surfaces nearest to a point lead: Newton's method
/// for their common point, from foot points and tangent planes.
/// @param bodies     closed or open surfaces that do not hang together
/// @param reach_mm   bodies farther than this from the point have no part in it
/// @param common_mm  points of two bodies that are as near as this are one
bool bodies_meet(const BodySurfaces& bodies, const geom::Vec3& point, double reach_mm,
                 double common_mm);

/// Bodies of the output may cross where those of the input do. What else crosses becomes a
/// self-intersection of the shape.
void find_new_crossings(ShapeFigures& figures, const BodySurfaces& input, double tolerance_mm);

}  // namespace patchwright::convert
