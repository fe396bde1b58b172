// Surfaces that pass through themselves or each other.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/bspline.h>

#include <array>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::measure {

/// A place where a surface meets itself, or two surfaces cross.
struct SelfIntersection {
    std::array<int, 2> surfaces{};  ///< numbers in the list; the same one twice for itself
    geom::Vec3 point = geom::Vec3::Zero();
    std::array<Eigen::Vector2d, 2> uv;  ///< the two places that meet there
    /// False: it could not be excluded within a bounded number of steps, as for surfaces without
    /// area; the places are two that may meet.
    bool is_found = true;
};

/// One self-intersection of each surface that has any, in the order of the list, then one of each
/// pair of surfaces that cross. Sides that are joined, to each other (closed surfaces) or to those
/// of other surfaces, and sides that are a point are none, nor are loops that stay within the
/// resolution of the place where they close, and surfaces that reach into each other by less.
/// @param resolution_mm  parts of the surface smaller than this are not looked into; with a tenth
/// of a fit's tolerance all faces are found that FreeCAD's boolean check finds, and folds of its
/// size as well
/// @throw InvalidArgument when the resolution is not positive
/// @throw Cancelled when `progress` says stop
std::vector<SelfIntersection> find_self_intersections(
    const std::vector<geom::BsplineSurface>& surfaces, double resolution_mm,
    const base::Progress& progress = {});

}  // namespace patchwright::measure
#pragma GCC visibility pop
