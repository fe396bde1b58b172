// How far a fitted level is from the reference, face by face.
#pragma once

#include "fit/loop/level_fit.h"

#include <Eigen/Geometry>

namespace patchwright::fit {

/// Of a face's samples; where a cage has other faces than quads, of all their sectors together.
struct FaceError {
    double max = 0.0;
    /// Largest distance of points of the reference to which the face is nearest.
    double reverse = 0.0;
    Eigen::Vector2d reverse_at = Eigen::Vector2d::Zero();  ///< its limit point, in the face
    /// Of all such limit points that are farther away than the tolerance.
    Eigen::AlignedBox<double, 2> beyond;
    int beyond_count = 0;
    /// How much the distance vector changes along u and along v: which direction is too coarse.
    double change_u = 0.0, change_v = 0.0;
    /// Largest distances of chains on sides along u and along v from their features.
    double curve_u = 0.0, curve_v = 0.0;

    [[nodiscard]] double largest() const { return std::max({max, reverse, curve_u, curve_v}); }
};

struct LevelError {
    Distances surface, curves;
    Distances reverse;  ///< of points of the reference from the limit surface
    std::vector<FaceError> faces;
};

/// On a grid over all faces, borders included and denser than the one that was fitted.
/// @param points  of the reference, to be looked for on the limit surface
LevelError measure(const mesh::Cage& cage, const LevelFit& fitted,
                   const geom::ReferenceSurface& reference, const std::vector<geom::Vec3>& points,
                   const FitOptions& options);

}  // namespace patchwright::fit
