#include "measure/limit_search.h"

#include "measure/limit_deviation.h"
#include "measure/limit_sites.h"
#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/deviation.h>

#include <catch2/catch.hpp>

#include <cmath>

using namespace patchwright;
using geom::Vec3;

TEST_CASE("the limit point near a point is the nearest one", "[measure][oracle]") {
    const mesh::Cage cage = GENERATE(test::torus(9, 6, 3.0, 1.0), test::fan(5), test::fan(3),
                                     test::random_cage(4), test::random_cage(7, {.open = true}));
    const auto sites = measure::face_sites(*cage.topology);
    const subd::LimitEvaluator evaluator(cage.topology);
    // All limit points of a fine grid: nothing may be nearer than these by more than their width.
    constexpr int fine = 60;
    std::vector<Vec3> points;
    double width = 0.0;
    for (const subd::Site& site : sites) {
        for (int i = 0; i <= fine; ++i) {
            for (int j = 0; j <= fine; ++j) {
                points.push_back(evaluator.position(
                    cage.points, {site.face, double(i) / fine, double(j) / fine, site.sector}));
                if (j > 0) width = std::max(width, (points.back() - points.end()[-2]).norm());
            }
        }
    }
    std::vector<Vec3> queries;
    for (std::size_t k = 0; k < 200; ++k) {
        const double offset = 0.02 * std::sin(double(k));
        queries.push_back(points[k * 7919 % points.size()] + offset * Vec3(0.5, -0.3, 0.8));
    }
    const auto near = measure::LimitSearch(cage.topology).nearest(cage.points, queries);
    REQUIRE(near.size() == queries.size());
    for (std::size_t k = 0; k < queries.size(); ++k) {
        double nearest = 1e300;
        for (const Vec3& p : points) nearest = std::min(nearest, (p - queries[k]).norm());
        const subd::Site& site = sites[std::size_t(near[k].site)];
        const Vec3 there =
            evaluator.position(cage.points, {site.face, near[k].u, near[k].v, site.sector});
        CHECK((there - near[k].point).norm() < 1e-12);
        CHECK(near[k].distance == Approx((there - queries[k]).norm()).margin(1e-12));
        CHECK(near[k].distance <= nearest + 1e-9);
        // Between grid points the surface may be nearer by what Pythagoras leaves.
        CHECK(near[k].distance >= std::sqrt(std::max(0.0, nearest * nearest - width * width)));
    }
}

TEST_CASE("a search that faces a direction does not find the far side of a thin part",
          "[measure]") {
    mesh::Cage ring = test::torus(12, 8, 3.0, 1.0);
    ring.points.col(2) *= 0.05;
    const measure::LimitSearch search(ring.topology);
    std::vector<Vec3> queries, facing;
    for (int k = 0; k < 12; ++k) {  // within the ring, nearer to the side that faces away
        const double a = 0.5 * k, up = k % 2 == 0 ? 1.0 : -1.0;
        queries.emplace_back(3.1 * std::cos(a), 3.1 * std::sin(a), -0.02 * up);
        facing.emplace_back(0.5, 0.0, 2.0 * up);  // of any length
    }
    const auto any = search.nearest(ring.points, queries);
    const auto faced = search.nearest(ring.points, queries, facing);
    for (std::size_t k = 0; k < queries.size(); ++k) {
        const double up = facing[k].z() / 2.0;
        CHECK(any[k].normal.z() * up < -0.99);
        CHECK(faced[k].normal.z() * up > 0.99);
        // Both sides are flat there: one is as far below the middle as the other is above.
        CHECK(faced[k].distance - any[k].distance == Approx(0.04).epsilon(0.02));
    }
    const mesh::Cage fan = test::fan(5);  // open: nothing faces down
    const auto none = measure::LimitSearch(fan.topology)
                          .nearest(fan.points, {Vec3(0.1, 0.2, 0.1)}, {-Vec3::UnitZ()});
    CHECK(std::isinf(none[0].distance));
}

TEST_CASE("a limit surface is measured both ways, face by face", "[measure][oracle]") {
    const mesh::Cage cage = test::cube(2.0);
    const test::Sphere sphere(0.6);
    constexpr int n = 6;
    // Above the middle of face 0, which is the lowest.
    const std::vector<Vec3> points{{0.0, 0.0, -0.9}};
    const measure::LimitDeviation found =
        measure::measure_limit(cage, sphere, points, {.intervals = n, .far_mm = 0.01});
    const subd::LimitEvaluator evaluator(cage.topology);
    std::vector<double> of_face(6, 0.0);
    double squares = 0.0;
    for (const mesh::FaceId f : cage.topology->faces()) {
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n; ++j) {
                const Vec3 p = evaluator.position(cage.points, {f, double(i) / n, double(j) / n});
                const double distance = std::abs(p.norm() - 0.6);
                of_face[f.index()] = std::max(of_face[f.index()], distance);
                squares += distance * distance;
            }
        }
    }
    REQUIRE(found.faces.size() == 6);
    for (std::size_t f = 0; f < 6; ++f) CHECK(found.faces[f].max == Approx(of_face[f]));
    CHECK(found.surface.count == 6 * (n + 1) * (n + 1));
    CHECK(found.surface.rms() == Approx(std::sqrt(squares / double(found.surface.count))));
    // The limit surface is nearest straight above, in the middle of its face.
    const Vec3 middle = evaluator.position(cage.points, {mesh::FaceId{0}, 0.5, 0.5});
    CHECK(found.reverse.max == Approx(std::abs(-0.9 - middle.z())));
    CHECK(found.faces[0].reverse == found.reverse.max);
    CHECK(found.faces[0].beyond_count == 1);
    CHECK((found.faces[0].reverse_at - Eigen::Vector2d(0.5, 0.5)).norm() < 1e-6);
    for (std::size_t f = 1; f < 6; ++f) CHECK(found.faces[f].reverse == 0.0);
    CHECK_THROWS_AS(
        measure::measure_limit(cage, sphere, points,
                               {.progress = [](std::string_view, double) { return false; }}),
        base::Cancelled);
}

TEST_CASE("the largest deviation of a spline surface is that of its samples", "[measure][oracle]") {
    // The square of side 1 in the plane z = 0.25, as a bicubic patch: 0.25 above the disc.
    geom::BsplineSurface square;
    square.knots_u = square.knots_v = {0, 0, 0, 0, 1, 1, 1, 1};
    square.points.resize(16, 3);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) square.points.row(4 * i + j) = Vec3(i / 3.0, j / 3.0, 0.25);
    const test::Disc disc;
    // The sample nearest to the corner (1, 1) is beyond the disc's rim.
    const double beyond = std::sqrt(2.0) * 11.5 / 12 - 1.0;
    CHECK(measure::largest_deviation(square, disc) == Approx(std::hypot(beyond, 0.25)));
    CHECK(measure::largest_deviation(square, disc, 1) == Approx(0.25));
    CHECK_THROWS_AS(measure::largest_deviation(square, disc, 0), base::InvalidArgument);
}
