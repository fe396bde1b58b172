// Pieces of a B-spline surface as Bezier patches with what bounds them.
#pragma once

#include "measure/direction_cone.h"

#include <patchwright/geom/bspline.h>

#include <array>
#include <vector>

namespace patchwright::measure {

/// A rectangle of parameters with bounds of the surface over it.
struct Extent {
    std::array<double, 2> u{}, v{};
    geom::Box3 box;
    DirectionCone du, dv;  ///< of the derivatives
    [[nodiscard]] double size() const { return box.diagonal(); }
};

struct BezierPiece : Extent {
    Eigen::Matrix<double, 16, 3, Eigen::RowMajor> net;  ///< (i, j) in row 4 i + j, i along u

    /// Derivatives are those in the shares.
    /// @param s, t  shares of the ranges of u and v
    [[nodiscard]] geom::BsplineSurface::Evaluation at(double s, double t) const;
    /// Across the direction in which it is longer.
    /// @param least_mm  derivatives shorter than this have no direction
    [[nodiscard]] std::array<BezierPiece, 2> halves(double least_mm) const;
};

/// One piece a span that is not empty.
struct BezierGrid {
    std::size_t spans_u = 0, spans_v = 0;
    std::vector<BezierPiece> pieces;  ///< (i, j) is i * spans_v + j, i along u
};
BezierGrid bezier_grid(const geom::BsplineSurface& surface, double least_mm);

}  // namespace patchwright::measure
