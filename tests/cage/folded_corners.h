// Corners of quads in a plane that are turned over.
#pragma once

#include "cage/blocks/folded_quads.h"

#include <vector>

namespace patchwright::test {

/// How many corners of quads are concave or flat as seen against the z axis.
inline int folded_corners(const std::vector<geom::Vec3>& points,
                          const std::vector<std::vector<int>>& faces) {
    int count = 0;
    for (const std::vector<int>& face : faces)
        for (int k = 0; k < 4; ++k)
            count += cage::corner_sine(points, face, k, geom::Vec3::UnitZ()) <= 0.0 ? 1 : 0;
    return count;
}

}  // namespace patchwright::test
