// How far two surfaces may be from each other between points where both are known to second order.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <array>
#include <optional>

namespace patchwright::measure {

/// A surface at a point, to second order.
struct SurfaceShape {
    geom::Vec3 point = geom::Vec3::Zero();
    geom::Vec3 normal = geom::Vec3::Zero();    ///< unit, or zero where there is none
    std::optional<geom::Curvature> curvature;  ///< none where the surface is degenerate
};

/// A point of a surface and its foot point on another one.
struct ShapePair {
    SurfaceShape point, foot;

    [[nodiscard]] geom::Vec3 offset() const { return point.point - foot.point; }
    [[nodiscard]] double distance() const { return offset().norm(); }
};

/// Between the corners of a triangle, which lie on the one surface, offsets to the other one are
/// close to those that are linearly interpolated between the corners, which are nowhere longer than
/// at the corners. How much longer they may be by the shape of the surfaces at the corners, mm: the
/// difference of the two surfaces' heights above the flat triangles of the points and of the feet.
/// Where normals turn by less than 45 degrees from one end of a side to the other, the heights are
/// those of parabolas with the ends' normals or curvatures, whichever differ more. Otherwise there
/// may be an edge between, and the chord is no farther from a surface than from the tangent plane
/// at that end where this is nearer. No safety is included. Nothing where a normal or a curvature
/// is not known. (The error of linear interpolation on triangles: Waldron, The error in linear
/// interpolation at the vertices of a simplex, 1998.)
std::optional<double> interpolation_error(const std::array<const ShapePair*, 3>& corners);

}  // namespace patchwright::measure
