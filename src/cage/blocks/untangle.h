// Quads that fold are opened by moving their points within the model.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// Where a point may go.
struct Freedom {
    bool free = true;  ///< anywhere on the surface
    int curve = -1;    ///< if not free: along this feature; -1: nowhere
};

/// Sine of the angle at a quad's corner k as seen against a unit normal.
double corner_sine(const std::vector<geom::Vec3>& points, const std::vector<int>& face, int k,
                   const geom::Vec3& normal);

/// Moves points of quads with angles close to 0 or 180 degrees, and of their neighbours, to where
/// the least sine around them is larger, step by step in all directions; quads that are well
/// formed stay.
/// @param faces    quads
/// @param points   on the model; moved
/// @param freedom  one a point
void untangle(const std::vector<std::vector<int>>& faces, std::vector<geom::Vec3>& points,
              const std::vector<Freedom>& freedom, const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
