// Circular cones that bound directions, and whether some of them fit into one half-space.
#pragma once

#include <patchwright/geom/types.h>

#include <initializer_list>

namespace patchwright::measure {

/// All unit vectors within an angle of an axis. Empty: no direction at all.
struct DirectionCone {
    geom::Vec3 axis = geom::Vec3::Zero();  ///< unit, or zero when empty
    double cosine = 1.0, sine = 0.0;       ///< of the angle, which is 0 to pi

    [[nodiscard]] bool empty() const { return axis.isZero(0.0); }
    [[nodiscard]] DirectionCone opposite() const { return {-axis, cosine, sine}; }
};

using Directions = Eigen::Matrix<double, 12, 3, Eigen::RowMajor>;

/// Around the first `count` rows. @pre none is zero
DirectionCone cone_of(const Directions& vectors, Eigen::Index count);
/// Around both.
DirectionCone merge(const DirectionCone& a, const DirectionCone& b);

/// Whether some direction makes less than a right angle with all that are in the cones, so that no
/// sum of such vectors vanishes. False may also mean that none was found in a few steps.
bool share_half_space(std::initializer_list<DirectionCone> cones);

}  // namespace patchwright::measure
