#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/curve.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

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

}  // namespace

TEST_CASE("curves: the limit of a polygon is the limit of its refinement", "[subd][oracle]") {
    for (const CurveScheme scheme : {CurveScheme::CubicEdgeSplit, CurveScheme::CornerCutting}) {
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
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {2, true}, 0.0), base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {4, false}, 3.1),
                    base::InvalidArgument);
    CHECK_THROWS_AS(curve_mask(CurveScheme::CubicEdgeSplit, {4, false}, NAN),
                    base::InvalidArgument);
}
