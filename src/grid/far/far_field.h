// From the last layer to a sphere.
#pragma once

#include "grid/far/enclosing_sphere.h"

#include <patchwright/base/progress.h>

namespace patchwright::grid {

struct FarFieldOptions {
    double growth = 1.2;  ///< of the cells' heights along lines
    base::Progress progress;
};

/// Fronts between the last layer and a sphere; the last one lies on it. Each cell comes as near as
/// it can to right angles, and to lengths that go from those of the last layer to those of even
/// cells on the sphere.
/// @param layers  the last two fronts of the layers
/// @throw UsageError for a sphere that does not hold the layers, and for more points than memory
///        holds; Cancelled
std::vector<geom::Points> far_fronts(const Plan& plan, const FrontMesh& mesh, const Sphere& sphere,
                                     const std::array<geom::Points, 2>& layers,
                                     const FarFieldOptions& options);

}  // namespace patchwright::grid
