#include "measure/spline_shapes.h"
#include "support/analytic_references.h"
#include "support/analytic_wing.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/folds.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;
using measure::find_folds;
using test::spline_surface;

namespace {

geom::BsplineSurface sphere_patch(double radius) {
    return spline_surface(60, 30, [=](double u, double v) {
        const double a = 2 * M_PI * u, b = M_PI * v;
        return Vec3(radius * std::cos(a) * std::sin(b), radius * std::sin(a) * std::sin(b),
                    -radius * std::cos(b));
    });
}

geom::BsplineSurface turned(geom::BsplineSurface s) {
    for (Eigen::Index i = 0; i < s.rows() / 2; ++i) {
        for (Eigen::Index j = 0; j < s.columns(); ++j)
            s.point(i, j).swap(s.point(s.rows() - 1 - i, j));
    }
    return s;
}

}  // namespace

TEST_CASE("a sphere does not fold against itself", "[measure][oracle]") {
    const test::Sphere sphere(10.0);
    const std::vector patches{sphere_patch(10.0)};
    const measure::FoldFigures f = find_folds(patches, sphere, {.tolerance_mm = 0.1});
    CHECK(f.samples == 60 * 30 * 16);
    CHECK(f.folded == 0);
    CHECK_FALSE(f.worst);

    const std::vector inward{turned(sphere_patch(10.0))};
    CHECK(find_folds(inward, sphere, {.tolerance_mm = 0.1}).folded == f.samples);
    CHECK(find_folds(inward, sphere, {.tolerance_mm = 0.1, .may_face_away = true}).folded == 0);
    CHECK_THROWS_AS(find_folds(patches, sphere, {}), base::InvalidArgument);

    CHECK(f.by_face.empty());
    const measure::FoldFigures some = find_folds({inward.front(), patches.front(), inward.front()},
                                                 sphere, {.tolerance_mm = 0.1});
    REQUIRE(some.by_face.size() == 2);
    CHECK(some.by_face[0].face == 0);
    CHECK(some.by_face[1].face == 2);
}

TEST_CASE("a folded sheet is found where it folds", "[measure][oracle]") {
    const test::Disc disc;
    // x runs back between u = 0.4 and 0.6, where it is near 0.
    const auto sheet = spline_surface(60, 6, [](double u, double v) {
        const double s = u - 0.5, back = std::exp(-400.0 * s * s);
        return Vec3(s - 0.2 * s * 10.0 * back, 0.4 * (v - 0.5), 1e-3 * std::sin(20.0 * s));
    });
    const std::vector surfaces{sheet};
    const measure::FoldFigures f = find_folds(surfaces, disc, {.tolerance_mm = 1e-3});
    REQUIRE(f.worst);
    CHECK(f.folded > 10);
    CHECK(f.folded < f.samples / 4);
    CHECK(std::abs(f.worst->point.x()) < 0.1);
    CHECK(f.worst->angle_rad > 3.0);
    // A crease of the output there: within the tolerance of it normals may turn.
    geom::BsplineCurve crease{test::uniform_knots(1), geom::Points(4, 3)};
    for (Eigen::Index i = 0; i < 4; ++i)
        crease.points.row(i) << 0.0, 0.4 * (double(i) / 3 - 0.5), 0.0;
    CHECK(find_folds(surfaces, disc, {.tolerance_mm = 0.2, .creases = {crease}}).folded == 0);
    CHECK(find_folds(surfaces, disc, {.tolerance_mm = 1e-3, .creases = {crease}}).folded > 10);
}

TEST_CASE("thin and sharp shapes do not fold against themselves", "[measure][oracle]") {
    const test::NacaWing wing;
    const auto itself = spline_surface(
        80, 4, [](double u, double v) { return test::NacaWing::point(2 * u - 1, v); });
    std::vector surfaces{itself};
    CHECK(find_folds(surfaces, wing, {.tolerance_mm = 1e-3, .may_face_away = true}).folded == 0);

    // The same with a trailing edge rounded by a radius below the tolerance.
    constexpr double radius = 1e-3;
    const auto rounded = spline_surface(200, 4, [](double u, double v) {
        // Round the edge in the middle of u: a half circle of the radius.
        const double cut = 1.0 - 1e-3;
        if (u < 0.45) return test::NacaWing::point(cut * u / 0.45, v);
        if (u > 0.55) return test::NacaWing::point(-cut * (1.0 - u) / 0.45, v);
        const Vec3 a = test::NacaWing::point(cut, v), b = test::NacaWing::point(-cut, v);
        const double angle = M_PI * ((u - 0.45) / 0.1 - 0.5);
        const Vec3 across = 0.5 * (a - b), middle = 0.5 * (a + b);
        return Vec3(middle - std::sin(angle) * across + radius * std::cos(angle) * Vec3::UnitX());
    });
    surfaces = {rounded};
    const auto folded = [&](double tolerance) {
        return find_folds(surfaces, wing, {.tolerance_mm = tolerance, .may_face_away = true})
            .folded;
    };
    CHECK(folded(1e-2) == 0);  // the edge is within 6.2 radii of the rounding's tip
    CHECK(folded(1e-4) > 0);
}
