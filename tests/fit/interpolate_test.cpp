#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/fit/interpolate.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Cholesky>
#include <random>

using namespace patchwright;
using mesh::FaceId;

TEST_CASE("limit positions of all vertices go through given points", "[fit][oracle]") {
    for (unsigned seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage = test::random_cage(
            seed,
            {.open = seed % 2 == 1, .semi_sharp = seed % 3 == 0, .valence = seed % 4 == 3 ? 7 : 0});
        // The cage itself as data: its limit must then lie outside of it.
        const fit::InterpolationResult result = fit::interpolate_vertices(cage, cage.points);
        CHECK(result.met);
        for (const mesh::VertexId v : cage.topology->vertices()) {
            CHECK((subd::limit_position(result.cage, v) - cage.points.row(v.value).transpose())
                      .norm() < 1e-12);
        }
    }
}

TEST_CASE("of all cages through the points the nearest is found", "[fit][oracle]") {
    const mesh::Cage cage = test::random_cage(5);
    std::mt19937 random(1);
    std::uniform_real_distribution<> unit(0, 1);
    std::vector<subd::Location> places;
    for (int f = 0; f < cage.topology->face_count(); f += 3) {
        places.push_back({FaceId{f}, unit(random), unit(random)});
    }
    const subd::LimitEvaluator evaluator(cage.topology);
    geom::Points targets(Eigen::Index(places.size()), 3);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(targets.rows(), cage.points.rows());
    geom::Points residual(targets.rows(), 3);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto row = Eigen::Index(i);
        const geom::Vec3 p = evaluator.position(cage.points, places[i]);
        targets.row(row) = p.transpose() + 0.1 * Eigen::RowVector3d(unit(random), 0.3, -0.2);
        residual.row(row) = targets.row(row) - p.transpose();
        const subd::Mask mask = evaluator.mask(places[i]);
        for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
            dense(row, mask.vertices[k]) = mask.rows(0, Eigen::Index(k));
        }
    }
    const fit::InterpolationResult result = fit::interpolate(cage, places, targets);
    CHECK(result.met);
    const geom::Points least =
        dense.transpose() * (dense * dense.transpose()).ldlt().solve(Eigen::MatrixXd(residual));
    CHECK((result.cage.points - cage.points - least).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("interpolation says when targets contradict and checks what it is given",
          "[fit][errors]") {
    const mesh::Cage cage = test::cube(2.0);
    const std::vector<subd::Location> twice{{FaceId{0}, 0.5, 0.5}, {FaceId{0}, 0.5, 0.5}};
    geom::Points targets(2, 3);
    targets << 0, 0, -1, 0, 0, -2;
    const fit::InterpolationResult result = fit::interpolate(cage, twice, targets);
    CHECK_FALSE(result.met);
    CHECK(result.largest_distance == Approx(0.5));
    CHECK_THROWS_AS(fit::interpolate(cage, twice, geom::Points(1, 3)), base::InvalidArgument);
    const std::vector<subd::Location> off{{FaceId{9}, 0.5, 0.5}};
    CHECK_THROWS_AS(fit::interpolate(cage, off, geom::Points(1, 3)), base::InvalidArgument);
    const std::vector<subd::Location> outside{{FaceId{0}, 1.5, 0.5}};
    CHECK_THROWS_AS(fit::interpolate(cage, outside, geom::Points(1, 3)), base::InvalidArgument);
}

TEST_CASE("a fit by interpolation puts the limit points of all vertices on the reference",
          "[fit][oracle]") {
    const test::Torus torus(3.0, 1.0);
    const mesh::Cage cage = test::torus(9, 7, 3.1, 0.9);
    const fit::FitResult result =
        fit::fit(cage, torus, {.tolerance_mm = 1e-2, .interpolate = true});
    REQUIRE(result.levels.size() == 1);
    CHECK(result.cage.topology == cage.topology);
    const double limit = fit::interpolation_limit_rel * torus.bounds().diagonal();
    REQUIRE(result.levels[0].interpolated_mm.has_value());
    CHECK(*result.levels[0].interpolated_mm <= limit);
    double before = 0.0;
    for (const mesh::VertexId v : cage.topology->vertices()) {
        CHECK(torus.foot_point(subd::limit_position(result.cage, v), {}).distance <= limit);
        before = std::max(before, torus.foot_point(subd::limit_position(cage, v), {}).distance);
    }
    CHECK(before > 0.1);
    // Between the vertices it is a fit of its own order, not exact.
    CHECK(result.levels[0].max_mm > 1e-4);
    CHECK(result.levels[0].max_mm < 0.1 * before);
    CHECK(result.within_tolerance == (result.levels[0].largest() <= 1e-2));
}

TEST_CASE("a fit by interpolation refuses what it cannot do", "[fit][errors]") {
    const test::Sphere sphere(1.0);
    const fit::FitOptions options{.interpolate = true};
    // A cube's eight masks depend on each other: alternating signs give the limit point 0. What is
    // on the sphere in this way is out of reach for a cube that is not symmetric.
    mesh::Cage cube = test::cube(2.0);
    CHECK_NOTHROW(fit::fit(cube, sphere, options));
    cube.points.row(0) *= 1.5;
    CHECK_THROWS_WITH(fit::fit(cube, sphere, options), Catch::Contains("subdivide the cage once"));
    CHECK_NOTHROW(fit::fit(subd::refine(cube, 1), sphere, options));
    CHECK_THROWS_WITH(fit::fit(test::cube(2.0, {.pins = {3}}), sphere, options),
                      Catch::Contains("vertex 3 is pinned"));
}
