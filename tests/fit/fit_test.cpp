#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

TEST_CASE("a cube cage is fitted to a sphere within the tolerance", "[fit][oracle]") {
    const auto result =
        fit::fit(subd::refine(test::cube(2.0), 1), test::Sphere(1.0), {.tolerance_mm = 1e-4});
    REQUIRE(result.met);
    CHECK(result.levels.back().max_mm <= 1e-4);
    // The fit's own figures are those of the limit surface.
    const subd::LimitEvaluator evaluator(result.cage.topology);
    for (const mesh::FaceId f : result.cage.topology->faces()) {
        CHECK(std::abs(evaluator.position(result.cage.points, {f, 0.21, 0.83}).norm() - 1.0) <
              1e-4);
    }
}

TEST_CASE("the error on a torus falls with refinement at fourth order", "[fit][oracle]") {
    // Bicubic splines: halving the faces divides the error by 16, a little less this early.
    const auto error = [](int nu, int nv) {
        return fit::fit(test::torus(nu, nv, 3.0, 1.0), test::Torus(3.0, 1.0),
                        {.tolerance_mm = 1e-12, .max_levels = 0})
            .levels.back()
            .rms_mm;
    };
    CHECK(error(12, 8) / error(24, 16) > 12.0);
}

TEST_CASE("creases and corners of a cube go to the edges and corners of a box", "[fit][oracle]") {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] < face[(i + 1) % 4]) {
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
            }
        }
    }
    mesh::Cage cage = test::cube(1.8, tags);
    cage.points.row(3) += Eigen::RowVector3d(0.05, -0.03, 0.02);
    const auto result = fit::fit(cage, test::Box(), {.tolerance_mm = 1e-9});
    CHECK(result.met);
    CHECK(result.levels.size() == 1);
    CHECK((result.cage.points.cwiseAbs().array() - 1.0).abs().maxCoeff() < 1e-9);
}

TEST_CASE("an open cage's boundary goes to the free edge", "[fit][oracle]") {
    mesh::Cage cage = test::grid(4, 4);
    cage.points = (cage.points.array() - 2.0) * 0.35;
    cage.points.col(2).setConstant(0.2);
    const auto result = fit::fit(cage, test::Disc(), {.tolerance_mm = 1e-3});
    REQUIRE(result.met);
    const subd::LimitEvaluator evaluator(result.cage.topology);
    const mesh::Topology& t = *result.cage.topology;
    for (const mesh::VertexId v : t.vertices()) {
        if (t.is_boundary(v))
            CHECK(std::abs(subd::limit_position(result.cage, v).norm() - 1.0) < 1e-3);
    }
}

TEST_CASE("pinned control points do not move", "[fit]") {
    mesh::TopologyInput tags;
    tags.pins = {5};
    const mesh::Cage cage = test::cube(2.0, tags);
    const auto result = fit::fit(cage, test::Sphere(1.0), {.max_levels = 0});
    CHECK(result.cage.points.row(5) == cage.points.row(5));
    CHECK((result.cage.points.row(6) - cage.points.row(6)).norm() > 0.1);
}

TEST_CASE("missing the tolerance is an answer, not an error", "[fit]") {
    const auto result =
        fit::fit(test::cube(2.0), test::Sphere(1.0), {.tolerance_mm = 1e-9, .max_levels = 1});
    CHECK_FALSE(result.met);
    CHECK(result.levels.size() == 2);
    CHECK(result.levels[1].max_mm > 1e-9);
}

TEST_CASE("a fit can be cancelled and checks its options", "[fit][errors]") {
    CHECK_THROWS_AS(fit::fit(test::cube(2.0), test::Sphere(1.0),
                             {.progress = [](std::string_view, double) { return false; }}),
                    base::Cancelled);
    CHECK_THROWS_AS(fit::fit(test::cube(2.0), test::Sphere(1.0), {.tolerance_mm = 0.0}),
                    base::InvalidArgument);
}
