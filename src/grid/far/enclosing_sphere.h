// The far boundary of a volume grid.
#pragma once

#include "grid/front.h"

namespace patchwright::grid {

struct Sphere {
    geom::Vec3 centre;
    double radius_mm;
};

/// A sphere around the middle of the surface's box, or half a sphere around the nearest point of
/// the plane in which the surface ends.
/// @throw UsageError for surfaces that a sphere does not enclose as one layer of blocks: several
///        bodies, handles, borders that are not one line in one plane
Sphere enclosing_sphere(const Plan& plan, const FrontMesh& mesh, double radius_mm);

}  // namespace patchwright::grid
