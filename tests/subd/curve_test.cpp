#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/curve.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <tuple>
#include <utility>

using namespace patchwright;
using subd::CurveScheme;

namespace {

geom::Points values(const geom::Points& points, const subd::CurveMask& mask) {
    geom::Points sum = geom::Points::Zero(3, 3);
    for (int k = 0; k < mask.count; ++k) {
        sum += mask.rows.col(k) * points.row(mask.points[std::size_t(k)]);
    }
    return sum;
}

constexpr CurveScheme all_schemes[] = {CurveScheme::CubicEdgeSplit, CurveScheme::CornerCutting,
                                       CurveScheme::DeRham};

/// Sine of the angle between two vectors of three.
double sine(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b) {
    return a.normalized().cross(b.normalized()).norm();
}

/// Twice the area that a closed polygon in the plane z = 0 encloses.
double twice_area(const geom::Points& points) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Eigen::Index k = (i + 1) % points.rows();
        sum += points(i, 0) * points(k, 1) - points(k, 0) * points(i, 1);
    }
    return sum;
}

/// Twice the areas of the triangles of three neighbours of a closed polygon.
double twice_corners(const geom::Points& points) {
    double sum = 0.0;
    const Eigen::Index n = points.rows();
    for (Eigen::Index i = 0; i < n; ++i) {
        geom::Points corner(3, 3);
        for (Eigen::Index k = 0; k < 3; ++k) corner.row(k) = points.row((i + k) % n);
        sum += twice_area(corner);
    }
    return sum;
}

}  // namespace

TEST_CASE("curves: the limit of a polygon is the limit of its refinement", "[subd][oracle]") {
    for (const CurveScheme scheme : all_schemes) {
        for (const bool closed : {false, true}) {
            for (int n = 3; n < 9; ++n) {
                const geom::Points points = geom::Points::Random(n, 3);
                const geom::Points fine = subd::refine_curve(scheme, points, closed);
                const subd::Polygon polygon{n, closed}, finer{int(fine.rows()), closed};
                const int spans = subd::span_count(scheme, polygon);
                CHECK(subd::span_count(scheme, finer) == 2 * spans);
                for (const double share : {0.0, 0.1, 0.37, 0.5, 0.93, 1.0}) {
                    CAPTURE(int(scheme), closed, n, share);
                    const double t = share * spans;
                    const subd::CurveMask mask = subd::curve_mask(scheme, polygon, t);
                    const geom::Points a = values(points, mask);
                    const geom::Points b = values(fine, subd::curve_mask(scheme, finer, 2.0 * t));
                    CHECK((a.row(0) - b.row(0)).norm() < 1e-14);
                    if (scheme == CurveScheme::DeRham)
                        CHECK(sine(a.row(1), b.row(1)) < 1e-13);  // a direction
                    else
                        CHECK((a.row(1) - 2 * b.row(1)).norm() < 1e-13);
                    // Second derivatives of the quadratic curve jump at its knots.
                    if (scheme == CurveScheme::CubicEdgeSplit || t != std::floor(t)) {
                        CHECK((a.row(2) - 4 * b.row(2)).norm() < 1e-12);
                    }
                    const Eigen::Vector3d sums = mask.rows.rowwise().sum();
                    CHECK((sums - Eigen::Vector3d::Unit(0)).norm() < 1e-14);
                }
            }
        }
    }
}

TEST_CASE("curves: limits at vertices and edges are the closed forms", "[subd][oracle]") {
    const geom::Points points = geom::Points::Random(6, 3);
    const geom::Points cubic =
        values(points, subd::curve_mask(CurveScheme::CubicEdgeSplit, {6, false}, 2.0));
    CHECK((cubic.row(0) - (points.row(1) + 4 * points.row(2) + points.row(3)) / 6).norm() < 1e-15);
    CHECK((cubic.row(1) - (points.row(3) - points.row(1)) / 2).norm() < 1e-15);
    const geom::Points cut =
        values(points, subd::curve_mask(CurveScheme::CornerCutting, {6, false}, 2.0));
    CHECK((cut.row(0) - (points.row(2) + points.row(3)) / 2).norm() < 1e-15);
    CHECK((cut.row(1) - (points.row(3) - points.row(2))).norm() < 1e-15);
}

TEST_CASE("curves: middles of refined edges lie on the limits of cutting, along their edges",
          "[subd][oracle]") {
    constexpr int levels = 9;
    for (const CurveScheme scheme : {CurveScheme::CornerCutting, CurveScheme::DeRham}) {
        for (const bool closed : {false, true}) {
            const geom::Points points = geom::Points::Random(5, 3);
            geom::Points fine = points;
            for (int k = 0; k < levels; ++k) fine = subd::refine_curve(scheme, fine, closed);
            const int n = int(fine.rows()), spans = subd::span_count(scheme, {n, closed});
            CHECK(n == (closed ? 5 << levels : (3 << levels) + 2));
            for (int k = 0; k < spans; ++k) {
                const Eigen::RowVector3d a = fine.row(k), b = fine.row((k + 1) % n);
                const geom::Points at = values(
                    points, subd::curve_mask(scheme, {5, closed}, std::ldexp(double(k), -levels)));
                CHECK((at.row(0) - 0.5 * (a + b)).norm() < 1e-14);
                CHECK(sine(at.row(1), b - a) < 1e-10);  // edges are as short as 3^-9
            }
        }
    }
}

TEST_CASE("curves: de Rham's satisfies its functional equations", "[subd][oracle]") {
    // c(t / 2) of A, B, C is c(t) of the cut triangle's first three points, c((1 + t) / 2) that of
    // the last three (de Rham 1947).
    const geom::Points points = geom::Points::Random(3, 3);
    const geom::Points cut = subd::refine_curve(CurveScheme::DeRham, points, false);
    const auto c = [](const geom::Points& of, double t) {
        return values(of, subd::curve_mask(CurveScheme::DeRham, {3, false}, t)).row(0).eval();
    };
    for (const double t : {0.0, 1e-300, 0.1, 1.0 / 3.0, 0.5, 0.71, 1.0}) {
        CHECK((c(points, 0.5 * t) - c(cut.topRows(3), t)).norm() < 1e-14);
        CHECK((c(points, 0.5 * (1.0 + t)) - c(cut.bottomRows(3), t)).norm() < 1e-14);
    }
    CHECK((c(points, 0.0) - 0.5 * (points.row(0) + points.row(1))).norm() < 1e-15);
    // From 1/3 = 0.0101...: the fixed point of the first map after the second.
    Eigen::Matrix3d first, second;
    first << 2, 1, 0, 1, 2, 0, 0, 2, 1;
    second << 1, 2, 0, 0, 2, 1, 0, 1, 2;
    Eigen::Matrix3d both = second * first / 9.0;
    for (int k = 0; k < 6; ++k) both = (both * both).eval();
    // 1/3 in double precision is off by 2^-54, and the curve is Hoelder continuous by
    // log(3/2) / log(2).
    CHECK((c(points, 1.0 / 3.0) - both.row(0) * points).norm() < 1e-9);
}

TEST_CASE("curves: tangents of de Rham's follow Minkowski's question mark", "[subd][oracle]") {
    // ?([0; a1, a2, ...]) = 2 (2^-a1 - 2^-(a1 + a2) + ...), by continued fractions.
    const auto question_mark = [](int p, int q) {
        double sum = 0.0, sign = 2.0;
        int exponent = 0;
        while (p != 0) {
            exponent += q / p;
            sum += std::ldexp(sign, -exponent);
            sign = -sign;
            q = std::exchange(p, q % p);
        }
        return sum;
    };
    CHECK(question_mark(1, 2) == 0.5);
    CHECK(question_mark(2, 5) == 0.375);
    for (int q = 1; q < 30; ++q) {
        for (int p = 0; p <= q; ++p) {
            const double s = double(p) / q;
            const subd::CurveMask mask =
                subd::curve_mask(CurveScheme::DeRham, {3, false}, question_mark(p, q));
            CHECK((mask.rows.row(1).head<3>() - Eigen::RowVector3d(s - 1, 1 - 2 * s, s)).norm() <
                  1e-15);
            CHECK(mask.rows.row(2).isZero(0.0));
        }
    }
    // The golden ratio's is 2/3, next to which a number in double precision has a fraction that
    // agrees to more digits than it has itself.
    const double golden = subd::curve_mask(CurveScheme::DeRham, {3, false}, 2.0 / 3.0).rows(1, 2);
    CHECK(std::abs(golden - 0.5 * (std::sqrt(5.0) - 1.0)) < 1e-15);
}

TEST_CASE("curves: cutting takes the areas away that geometric series tell", "[subd][oracle]") {
    // A cut at c takes c^2 of each corner's triangle and leaves two corners of c (1 - 2 c) of it:
    // in all c^2 / (1 - 2 c (1 - 2 c)), which is 1/12 for a quarter and 1/7 for a third.
    geom::Points points = geom::Points::Zero(5, 3);
    points.leftCols<2>() << 0, 0, 4, -1, 5, 3, 2, 5, -1, 2;
    for (const auto& [scheme, share, left] : {std::tuple(CurveScheme::CornerCutting, 12.0, 0.25),
                                              {CurveScheme::DeRham, 7.0, 2.0 / 9.0}}) {
        const double before = twice_area(points), corners = twice_corners(points);
        geom::Points fine = points;
        constexpr int levels = 12;
        for (int k = 0; k < levels; ++k) fine = subd::refine_curve(scheme, fine, true);
        const double missing = std::pow(left, levels) * corners / share;
        CHECK(twice_area(fine) - missing == Approx(before - corners / share).epsilon(1e-12));
        CHECK(twice_corners(fine) == Approx(std::pow(left, levels) * corners).epsilon(1e-6));
    }
}

TEST_CASE("boundaries of surfaces are edge-split curves", "[subd][oracle]") {
    mesh::Cage cage = test::grid(5, 4);
    cage.points += 0.3 * geom::Points::Random(cage.points.rows(), 3);
    // The side v = 0 of the faces 0, 4, 8, ... has the vertices 0, 5, 10, ... of 5 a row.
    geom::Points side(6, 3);
    for (int i = 0; i < 6; ++i) side.row(i) = cage.points.row(5 * i);
    const subd::LimitEvaluator evaluator(cage.topology);
    for (const double t : {1.0, 1.3, 2.0, 2.9, 3.5}) {
        const int span = std::min(int(t), 4);
        const auto surface =
            evaluator.evaluate(cage.points, {mesh::FaceId{4 * span}, t - span, 0.0});
        const geom::Points curve =
            values(side, subd::curve_mask(CurveScheme::CubicEdgeSplit, {6, false}, t));
        CHECK((surface.position - curve.row(0).transpose()).norm() < 1e-14);
        CHECK((surface.du - curve.row(1).transpose()).norm() < 1e-13);
    }
}

TEST_CASE("curves: what has no curve is refused", "[subd][errors]") {
    using subd::curve_mask;
    CHECK_THROWS_AS(curve_mask(CurveScheme::CornerCutting, {2, false}, 0.0), base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::DeRham, {2, false}, 0.0), base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {2, true}, 0.0), base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {4, false}, 3.1),
                    base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {4, false}, NAN),
                    base::InvalidArgument);
}
