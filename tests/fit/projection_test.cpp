// Foot points of the samples of a fit.
#include "fit/loop/projector.h"
#include "fit/loop/sampling.h"
#include "support/cages.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <array>
#include <limits>

namespace patchwright {
namespace {

/// Vertices of a grid of 4 x 4 quads in the middle of the top of a plate that is 2 mm thick.
geom::Points on_top(const std::array<double, 5>& x) {
    geom::Points points(25, 3);
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            points.row(5 * i + j) << 50.0 + x[std::size_t(i)], 49.8 + 0.1 * j, 2.0;
    return points;
}

/// Samples of a plane, one a face, that are `off` below their targets and face as these do.
fit::Projection on_plane(const subd::LimitOperator& samples, const mesh::Cage& cage, double off) {
    fit::Projection p(samples, cage.points);
    p.normals = samples.normals(cage.points);
    p.target = p.limit;
    p.target.col(2).array() += off;
    p.jacobian_ratio.setOnes();
    return p;
}

}  // namespace

TEST_CASE("samples of a fold keep their foot points beside it", "[fit]") {
    // What faces as a fold of the top does, the bottom, is within the reach of the reference: 0.02
    // of the diagonal.
    const geom::MeshReference plate(test::triangle_box(100.0, 100.0, 2.0));
    REQUIRE(plate.foot_point({50.0, 50.0, 2.0}, -geom::Vec3::UnitZ()).distance == Approx(2.0));
    mesh::Cage cage = test::grid(4, 4);
    cage.points = on_top({-0.2, -0.1, 0.0, 0.1, 0.2});
    constexpr double any_reach = std::numeric_limits<double>::infinity();
    fit::Projector projector(cage, plate, {.tolerance_mm = 0.001}, any_reach, [] {});
    // Limit points of the middle lines are at 0.17, 0 and -0.17: the faces between, 0.1 by 0.1 mm
    // before, face down.
    const auto folded = projector.project_surface(on_top({-0.2, 0.3, 0.0, -0.3, 0.2}), nullptr);
    CHECK(folded.normals.col(2).minCoeff() < 0.0);
    CHECK(folded.distances.max < 1e-9);
}

TEST_CASE(
    "a sample that leaves the reference over an edge is inverted, not one whose foot point "
    "changes sides",
    "[fit]") {
    const mesh::Cage cage = test::grid(3, 3);
    const subd::LimitOperator samples(*cage.topology, {fit::interior_grid(1)},
                                      fit::face_sites(*cage.topology),
                                      subd::SampleRows::PointsAndTangents);
    const auto& rows = samples.site_rows();
    const fit::Projection now = on_plane(samples, cage, 0.2);
    fit::Projection next = now;
    // The foot point of sample 4 is on a face that faces the other way: nearer, as on the other
    // side of a thin part, or farther, as beyond the edge.
    next.jacobian_ratio[4] = -1.0;
    next.target.row(4) = next.limit.row(4) + Eigen::RowVector3d(0, 0, -0.1);
    const fit::Inversion across = inverted_by_step(rows, now, next);
    CHECK_FALSE(across.more);
    CHECK(across.sites == std::vector<std::size_t>{4});
    next.target.row(4) = next.limit.row(4) + Eigen::RowVector3d(-0.3, 0, 0);
    CHECK(inverted_by_step(rows, now, next).more);
    // The way back opens a fold.
    CHECK_FALSE(inverted_by_step(rows, next, now).more);
    // A sample that turns is inverted wherever its foot point is.
    next = now;
    next.jacobian_ratio[4] = -1.0;
    next.normals.row(4) *= -1.0;
    CHECK(inverted_by_step(rows, now, next).more);
}

}  // namespace patchwright
