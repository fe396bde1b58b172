// The curve schemes of the paper (Brakhage, Grid generation and grid conversion by subdivision
// schemes, introduction): cubic edge split, which creases and boundaries follow, and corner
// cutting.
#pragma once

#include <patchwright/geom/types.h>

#include <array>

#pragma GCC visibility push(default)
namespace patchwright::subd {

enum class CurveScheme {
    CubicEdgeSplit,  ///< vertices (1, 6, 1) / 8, edges (1, 1) / 2; limit: uniform cubic B-spline
    CornerCutting,   ///< edges cut at 1/4 and 3/4 (Chaikin 1974); limit: uniform quadratic B-spline
    DeRham           ///< edges cut at 1/3 and 2/3 (de Rham, Un peu de mathematiques a propos d'une
            ///< courbe plane, 1947); limit: a curve whose tangent turns continuously, of no
            ///< polynomial pieces
};

/// A control polygon's shape without its points.
struct Polygon {
    int points = 0;
    bool closed = false;
};

/// Pieces of the limit curve (but for DeRham's polynomial ones), which has the parameters 0 to
/// this. The edge-split curve of an open polygon runs from its first point to its last, a span an
/// edge; the others from the middle of the first edge to the middle of the last, a span an inner
/// vertex.
int span_count(CurveScheme scheme, const Polygon& polygon);

/// One step. Parameters of the finer polygon's curve are twice those of this one.
/// @param points  n x 3
/// @throw InvalidArgument for fewer than 2 points, or 3 when closed or cut
geom::Points refine_curve(CurveScheme scheme, const geom::Points& points, bool closed);

/// Limit point and derivatives as linear combinations of control points.
struct CurveMask {
    int count = 0;                ///< of the control points that take part, 4 at most
    std::array<int, 4> points{};  ///< each once
    /// Row d holds the coefficients of the d-th derivative; sums 1, 0, 0. By this parameter
    /// DeRham's curve has the derivative 0 wherever refinement puts a point, as lengths shrink to a
    /// third where parameters shrink to half: row 1 is the direction of its tangent, (1 - s) a + s
    /// b where it leaves the middle of the edge a for that of the edge b, with Minkowski's question
    /// mark ?(s) the parameter since then; row 2 is zero.
    Eigen::Matrix<double, 3, 4> rows = Eigen::Matrix<double, 3, 4>::Zero();
};

/// Exact but for rounding at every t: all numbers in double precision are points of some
/// refinement.
/// @throw InvalidArgument for polygons as in refine_curve() and parameters outside the curve
CurveMask curve_mask(CurveScheme scheme, const Polygon& polygon, double t);

}  // namespace patchwright::subd
#pragma GCC visibility pop
