#include <patchwright/base/error.h>
#include <patchwright/subd/curve.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::subd {

namespace {

/// Whether edges are cut and vertices lost; if not, edges are split and vertices stay.
bool cuts_corners(CurveScheme scheme) { return scheme != CurveScheme::CubicEdgeSplit; }

void check(CurveScheme scheme, const Polygon& polygon) {
    const int least = polygon.closed || cuts_corners(scheme) ? 3 : 2;
    if (polygon.points < least) {
        throw base::InvalidArgument(
            fmt::format("a polygon of {} points has no curve; at least {}", polygon.points, least));
    }
}

/// Uniform B-spline basis on one span, t in [0, 1]; row d is the d-th derivative.
Eigen::Matrix<double, 3, 4> cubic_basis(double t) {
    const double s = 1.0 - t;
    Eigen::Matrix<double, 3, 4> b;
    b << s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6,
        -s * s / 2, t * (1.5 * t - 2), s * (2 - 1.5 * s), t * t / 2,  //
        s, 3 * t - 2, 3 * s - 2, t;
    return b;
}

Eigen::Matrix<double, 3, 4> quadratic_basis(double t) {
    const double s = 1.0 - t;
    Eigen::Matrix<double, 3, 4> b;
    b << s * s / 2, 0.5 + s * t, t * t / 2, 0,  //
        -s, s - t, t, 0,                        //
        1, -2, 1, 0;
    return b;
}

/// The span of three points A, B, C, from the middle of AB to that of BC. Cutting gives four
/// points, of which the first and the last three have the halves of the span in the same way; the
/// edges of these are a third of (AB, AB + BC) and of (AB + BC, BC), so that tangents at the
/// middles follow the tree of Stern and Brocot.
Eigen::Matrix<double, 3, 4> de_rham_basis(double t) {
    Eigen::Matrix<double, 4, 3> cut;
    cut << 2, 1, 0, 1, 2, 0, 0, 2, 1, 0, 1, 2;
    cut /= 3.0;
    Eigen::Matrix3d window = Eigen::Matrix3d::Identity();  // its points, over A, B, C
    Eigen::Vector2d before(1, 0), after(0, 1);             // its edges, over AB, BC
    while (t > 0.0 && t < 1.0) {
        t *= 2.0;
        const bool second = t >= 1.0;
        window = (cut.middleRows<3>(second ? 1 : 0) * window).eval();
        (second ? before : after) = before + after;
        if (second) t -= 1.0;
    }
    const bool at_end = t == 1.0;
    const Eigen::Vector2d edge = at_end ? after : before;
    const double along = edge[1] / edge.sum();
    Eigen::Matrix<double, 3, 4> b = Eigen::Matrix<double, 3, 4>::Zero();
    b.row(0).head<3>() = 0.5 * (window.row(at_end ? 2 : 0) + window.row(1));
    b.row(1).head<3>() << along - 1.0, 1.0 - 2.0 * along, along;
    return b;
}

void add(CurveMask& mask, int point, const Eigen::Vector3d& weights) {
    int k = 0;
    while (k < mask.count && mask.points[std::size_t(k)] != point) ++k;
    if (k == mask.count) mask.points[std::size_t(mask.count++)] = point;
    mask.rows.col(k) += weights;
}

}  // namespace

int span_count(CurveScheme scheme, const Polygon& polygon) {
    if (polygon.closed) return polygon.points;
    return polygon.points - (cuts_corners(scheme) ? 2 : 1);
}

geom::Points refine_curve(CurveScheme scheme, const geom::Points& points, bool closed) {
    const auto n = static_cast<int>(points.rows());
    check(scheme, {n, closed});
    const int edges = closed ? n : n - 1;
    const auto at = [&](int i) { return points.row((i + n) % n); };
    if (cuts_corners(scheme)) {
        const double cut = scheme == CurveScheme::DeRham ? 1.0 / 3.0 : 0.25;
        geom::Points fine(2 * edges, 3);
        for (int i = 0; i < edges; ++i) {
            fine.row(2 * i) = (1.0 - cut) * at(i) + cut * at(i + 1);
            fine.row(2 * i + 1) = cut * at(i) + (1.0 - cut) * at(i + 1);
        }
        return fine;
    }
    geom::Points fine(n + edges, 3);
    for (int i = 0; i < n; ++i) {
        const bool end = !closed && (i == 0 || i == n - 1);
        fine.row(2 * i) = end ? at(i) : (0.125 * (at(i - 1) + at(i + 1)) + 0.75 * at(i)).eval();
    }
    for (int i = 0; i < edges; ++i) fine.row(2 * i + 1) = 0.5 * (at(i) + at(i + 1));
    return fine;
}

CurveMask curve_mask(CurveScheme scheme, const Polygon& polygon, double t) {
    check(scheme, polygon);
    const int spans = span_count(scheme, polygon);
    if (!(t >= 0.0 && t <= spans)) {
        throw base::InvalidArgument(
            fmt::format("curve parameter {} is not within 0 to {}", t, spans));
    }
    const int span = std::min(static_cast<int>(t), spans - 1);
    const bool cubic = scheme == CurveScheme::CubicEdgeSplit;
    const Eigen::Matrix<double, 3, 4> basis = cubic ? cubic_basis(t - span)
                                              : scheme == CurveScheme::DeRham
                                                  ? de_rham_basis(t - span)
                                                  : quadratic_basis(t - span);
    const int first = cubic ? span - 1 : span;
    const int n = polygon.points;
    CurveMask mask;
    for (int k = 0; k < (cubic ? 4 : 3); ++k) {
        const int i = first + k;
        if (polygon.closed) {
            add(mask, (i + n) % n, basis.col(k));
        } else if (i < 0 || i >= n) {
            // Beyond its ends an open polygon goes on as its mirror image: the ends stay.
            const int end = i < 0 ? 0 : n - 1;
            add(mask, end, 2.0 * basis.col(k));
            add(mask, 2 * end - i, -basis.col(k));
        } else {
            add(mask, i, basis.col(k));
        }
    }
    return mask;
}

}  // namespace patchwright::subd
