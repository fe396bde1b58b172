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

TEST_CASE("the volume inside a closed surface is that of its parts", "[bspline][oracle]") {
    geom::BsplineSurface s{{0, 0, 0, 0, 0.4, 1, 1, 1, 1}, {0, 0, 0, 0, 2, 2, 2, 2}, {}};
    s.points.resize(20, 3);
    // The plane z = 3 over [0, 5] x [0, 7]: a pyramid from the origin of a third of 5 * 7 * 3.
    for (Eigen::Index i = 0; i < 5; ++i) {
        // Greville abscissas make the parametrisation linear.
        const double u = (s.knots_u[std::size_t(i) + 1] + s.knots_u[std::size_t(i) + 2] +
                          s.knots_u[std::size_t(i) + 3]) /
                         3.0;
        for (Eigen::Index j = 0; j < 4; ++j) s.point(i, j) << 5.0 * u, 7.0 * double(j) / 3.0, 3.0;
    }
    const geom::SurfaceMoments pyramid = geom::moments(s, geom::Vec3::Zero());
    CHECK(pyramid.volume == Approx(35.0).epsilon(1e-14));
    CHECK((pyramid.of_volume / 35.0 - geom::Vec3(1.875, 2.625, 2.25)).norm() < 1e-13);
    CHECK(pyramid.area == Approx(35.0).epsilon(1e-14));
    CHECK((pyramid.of_area / 35.0 - geom::Vec3(2.5, 3.5, 3.0)).norm() < 1e-13);
    CHECK(geom::moments(s, {1, 2, 3}).volume == Approx(0.0).margin(1e-12));
    // z = x y over the unit square has the integral of z - x z_x - y z_y = -x y below it: -1/12.
    geom::BsplineSurface saddle{{0, 0, 0, 0, 1, 1, 1, 1}, {0, 0, 0, 0, 1, 1, 1, 1}, {}};
    saddle.points.resize(16, 3);
    for (Eigen::Index i = 0; i < 4; ++i)
        for (Eigen::Index j = 0; j < 4; ++j)
            saddle.point(i, j) << double(i) / 3.0, double(j) / 3.0, double(i * j) / 9.0;
    const geom::SurfaceMoments under = geom::moments(saddle, geom::Vec3::Zero());
    CHECK(under.volume == Approx(-1.0 / 12.0).epsilon(1e-13));
    CHECK(under.area == Approx(1.280789).epsilon(1e-6));  // of sqrt(1 + x^2 + y^2)
}

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
