#include <patchwright/geom/bspline.h>

#include <catch2/catch.hpp>

#include <cmath>

using namespace patchwright;
using geom::Vec3;

namespace {

const std::vector<double> graded_knots{0, 0, 0, 0, 0.125, 0.25, 0.25, 0.5, 1, 1, 1, 1};

/// Blossom of t^power at the three inner knots of control point i: the coefficient of t^power.
double monomial_coefficient(int power, std::size_t i) {
    const double a = graded_knots[i + 1], b = graded_knots[i + 2], c = graded_knots[i + 3];
    switch (power) {
        case 0: return 1.0;
        case 1: return (a + b + c) / 3;
        case 2: return (a * b + b * c + c * a) / 3;
        default: return a * b * c;
    }
}

}  // namespace

TEST_CASE("cubic B-splines reproduce cubic polynomials", "[geom][oracle]") {
    geom::BsplineCurve curve{graded_knots, geom::Points(8, 3)};
    for (std::size_t i = 0; i < 8; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            curve.points(Eigen::Index(i), axis) = monomial_coefficient(axis + 1, i);
        }
    }
    for (const double t : {0.0, 0.03, 0.125, 0.2, 0.25, 0.4, 0.5, 0.99, 1.0}) {
        CHECK(curve.at(t).isApprox(Vec3(t, t * t, t * t * t), 1e-14));
        const geom::BasisSpan b = geom::cubic_basis(graded_knots, t);
        Vec3 derivative = Vec3::Zero();
        for (int i = 0; i < 4; ++i) {
            derivative += b.derivative[i] * curve.points.row(b.first + i).transpose();
        }
        CHECK(derivative.isApprox(Vec3(1, 2 * t, 3 * t * t), 1e-12));
    }
}

TEST_CASE("bicubic surfaces and their derivatives reproduce monomials", "[geom][oracle]") {
    // x = u^2 v, y = v^3, z = u v^2
    geom::BsplineSurface surface{graded_knots, graded_knots, geom::Points(64, 3)};
    for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t j = 0; j < 8; ++j) {
            const auto c = [&](int power_u, int power_v) {
                return monomial_coefficient(power_u, i) * monomial_coefficient(power_v, j);
            };
            surface.point(Eigen::Index(i), Eigen::Index(j)) << c(2, 1), c(0, 3), c(1, 2);
        }
    }
    const double u = 0.3, v = 0.7;
    const auto e = surface.at(u, v);
    CHECK(e.position.isApprox(Vec3(u * u * v, v * v * v, u * v * v), 1e-14));
    CHECK(e.du.isApprox(Vec3(2 * u * v, 0, v * v), 1e-13));
    CHECK(e.dv.isApprox(Vec3(u * u, 3 * v * v, 2 * u * v), 1e-13));
}
