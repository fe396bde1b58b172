// The angle between two directions.
#pragma once

#include <patchwright/geom/types.h>

#include <Eigen/Geometry>
#include <cmath>

namespace patchwright::geom {

/// 0 to pi, accurate for small angles as well; 0 when a vector is zero.
inline double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace patchwright::geom
