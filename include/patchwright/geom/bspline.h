// Bicubic B-spline surfaces and cubic B-spline curves as plain data, with evaluation.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Clamped cubic B-spline curve.
struct BsplineCurve {
    std::vector<double> knots;  ///< n + 4 values, non-decreasing, first and last four equal
    Points points;              ///< n x 3 control points

    [[nodiscard]] double begin() const { return knots.front(); }
    [[nodiscard]] double end() const { return knots.back(); }
    /// @pre begin() <= t <= end()
    [[nodiscard]] Vec3 at(double t) const;
};

/// The same curve run the other way, over the same range.
BsplineCurve reversed(const BsplineCurve& curve);

/// The piece of the curve over [begin, end], exactly; all of it unchanged.
/// @pre curve.begin() <= begin < end <= curve.end()
BsplineCurve part(const BsplineCurve& curve, double begin, double end);

/// Clamped tensor-product bicubic B-spline surface.
struct BsplineSurface {
    std::vector<double> knots_u;  ///< rows + 4 values
    std::vector<double> knots_v;  ///< columns + 4 values
    /// rows * columns control points; (i, j) is row i * columns() + j; i runs along u
    Points points;

    struct Evaluation {
        Vec3 position, du, dv;
    };

    [[nodiscard]] Eigen::Index rows() const { return Eigen::Index(knots_u.size()) - 4; }
    [[nodiscard]] Eigen::Index columns() const { return Eigen::Index(knots_v.size()) - 4; }
    [[nodiscard]] auto point(Eigen::Index i, Eigen::Index j) {
        return points.row(i * columns() + j);
    }
    [[nodiscard]] auto point(Eigen::Index i, Eigen::Index j) const {
        return points.row(i * columns() + j);
    }
    /// @pre (u, v) lies within the knots' ranges
    [[nodiscard]] Evaluation at(double u, double v) const;
};

/// Integrals over a surface and over the cone from the origin to it, which counts where the normal
/// looks away from the origin: a closed surface's cones add up to what lies inside.
struct SurfaceMoments {
    double area = 0.0;
    double volume = 0.0;
    Vec3 of_area = Vec3::Zero();    ///< area times its centroid
    Vec3 of_volume = Vec3::Zero();  ///< volume times its centroid
};

/// Places count from `origin`. Volume and its moments are exact but for rounding, area and its
/// moments by six Gauss points a span and parameter.
SurfaceMoments moments(const BsplineSurface& surface, const Vec3& origin);

/// The four cubic basis functions that are non-zero at `t`, with derivatives.
struct BasisSpan {
    Eigen::Index first;  ///< index of the first of the four control points
    double value[4];
    double derivative[4];
};

/// Source: Piegl, Tiller, The NURBS Book (1997), A2.1 and A2.3.
/// @pre knots as in BsplineCurve, t within their range (the end belongs to the last span)
BasisSpan cubic_basis(const std::vector<double>& knots, double t);

/// The Bezier points of a span as combinations of its four control points: row k times the points
/// span - 3 to span is Bezier point k.
/// @pre knots[span] < knots[span + 1], both within the knots' range
Eigen::Matrix4d bezier_matrix(const std::vector<double>& knots, Eigen::Index span);

}  // namespace patchwright::geom
#pragma GCC visibility pop
