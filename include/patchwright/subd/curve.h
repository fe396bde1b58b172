// The curve schemes of the paper: cubic edge split, which creases and boundaries follow, and corner
// cutting.
#pragma once

#include <patchwright/geom/types.h>

#include <array>

#pragma GCC visibility push(default)
namespace patchwright::subd {

enum class CurveScheme {
    CubicEdgeSplit,  ///< vertices (1, 6, 1) / 8, edges (1, 1) / 2; limit: uniform cubic B-spline
    CornerCutting    ///< edges cut at 1/4 and 3/4 (Chaikin 1974); limit: uniform quadratic B-spline
};

/// A control polygon's shape without its points.
struct Polygon {
    int points = 0;
    bool closed = false;
};

/// Polynomial pieces of the limit curve, which has the parameters 0 to this. The edge-split curve
/// of an open polygon runs from its first point to its last, a span an edge; the corner-cutting
/// curve from the middle of the first edge to the middle of the last, a span an inner vertex.
int span_count(CurveScheme scheme, const Polygon& polygon);

/// One step. Parameters of the finer polygon's curve are twice those of this one.
/// @param points  n x 3
/// @throw InvalidArgument for fewer than 2 points, or 3 when closed or cut
geom::Points refine_curve(CurveScheme scheme, const geom::Points& points, bool closed);

/// Limit point and derivatives as linear combinations of control points.
struct CurveMask {
    int count = 0;                ///< of the control points that take part, 4 at most
    std::array<int, 4> points{};  ///< each once
    /// Row d holds the coefficients of the d-th derivative; sums 1, 0, 0.
    Eigen::Matrix<double, 3, 4> rows = Eigen::Matrix<double, 3, 4>::Zero();
};

/// @throw InvalidArgument for polygons as in refine_curve() and parameters outside the curve
CurveMask curve_mask(CurveScheme scheme, const Polygon& polygon, double t);

}  // namespace patchwright::subd
#pragma GCC visibility pop
