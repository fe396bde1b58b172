#include "fit/loop/projection.h"
#include "fit/loop/sampling.h"
#include "support/cages.h"

#include <catch2/catch.hpp>

using namespace patchwright;

namespace {

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
