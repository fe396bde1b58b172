// Pieces of a B-spline surface as Bezier patches with what bounds them.
#pragma once

#include "measure/direction_cone.h"

#include <patchwright/geom/bspline.h>

#include <array>
#include <vector>

namespace patchwright::measure {

/// Coordinates in which surfaces are compared. Straight lines, half-spaces and what lies apart stay
/// such under linear maps, so that a surface whose parameter lines meet at a small angle may be
/// looked at with the angle widened.
struct SurfaceFrame {
    Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
    double least_mm = 0.0;  ///< derivatives shorter than this have no direction
};

/// A rectangle of parameters with bounds of the surface over it.
struct Extent {
    std::array<double, 2> u{}, v{};
    geom::Box3 box;        ///< mm
    geom::Box3 framed;     ///< in the frame
    DirectionCone du, dv;  ///< of the derivatives, in the frame
    [[nodiscard]] double size() const { return box.diagonal(); }
};

struct BezierPiece : Extent {
    Eigen::Matrix<double, 16, 3, Eigen::RowMajor> net;  ///< mm; (i, j) in row 4 i + j

    /// Derivatives are those in the shares.
    /// @param s, t  shares of the ranges of u and v
    [[nodiscard]] geom::BsplineSurface::Evaluation at(double s, double t) const;
    /// Across the direction in which it is longer.
    [[nodiscard]] std::array<BezierPiece, 2> halves(const SurfaceFrame& frame) const;
};

/// Whether one direction makes an acute angle with all derivatives of both pieces, and another one
/// with those along u and an obtuse one with those along v: sharper than their cones where the
/// parameter lines meet at a small angle and turn together.
/// @param least_mm  derivatives shorter than this have no direction
bool run_one_way(const BezierPiece& a, const BezierPiece& b, double least_mm);

/// One piece a span that is not empty.
struct BezierGrid {
    std::size_t spans_u = 0, spans_v = 0;
    std::vector<BezierPiece> pieces;  ///< (i, j) is i * spans_v + j, i along u
};
BezierGrid bezier_grid(const geom::BsplineSurface& surface, const SurfaceFrame& frame);

}  // namespace patchwright::measure
