#include "grid/sample_cage.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/quality.h>

#include <catch2/catch.hpp>

#include <algorithm>

namespace patchwright {
namespace {

using grid::BlockLayout;
using grid::BlockPoints;
using grid::Plan;

mesh::TopologyInput with_corners() {
    mesh::TopologyInput tags;
    tags.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    return tags;
}

TEST_CASE("a size function is obeyed on all lines of its blocks", "[grid]") {
    const mesh::Cage torus = test::torus(8, 6, 3.0, 1.0);
    const geom::Vec3 middle(3.0, 0.0, 1.0);
    const auto size = [&](const geom::Vec3& p) { return 0.05 + 0.2 * (p - middle).norm(); };
    const Plan plan = grid::make_plan(grid::make_layout(torus), {.size = size});
    const grid::BlockEvaluator evaluator(plan);
    double worst = 0.0;
    std::int64_t cells = 0;
    for (int b = 0; b < 4; ++b) {
        const BlockPoints p = evaluator.evaluate(b);
        for (int i = 0; i + 1 < p.ni; ++i) {
            for (int j = 0; j < p.nj; ++j) {
                const geom::Vec3 a = p.at(i, j), c = p.at(i + 1, j);
                worst = std::max(worst, (c - a).norm() / size(0.5 * (a + c)));
            }
        }
        cells += std::int64_t(p.ni - 1) * (p.nj - 1);
    }
    // Lines inside blocks are blended from their edges, which do not know of each other.
    CHECK(worst < 1.5);
    // The smallest size everywhere would take this many.
    CHECK(double(cells) < 0.2 * 4 * M_PI * M_PI * 3.0 / (0.05 * 0.05));
    CHECK_THROWS_AS(
        grid::make_plan(grid::make_layout(torus), {.size = [](const geom::Vec3&) { return -1.0; }}),
        base::InvalidArgument);
}

TEST_CASE("quality of known grids", "[grid][oracle]") {
    // Unit squares.
    const Plan flat =
        grid::make_plan(grid::make_layout(test::grid(4, 4, with_corners())), {.cells = 8});
    const auto q = grid::measure_quality(grid::SurfaceGrid(flat));
    CHECK(q.blocks == 1);
    CHECK(q.interfaces == 0);
    CHECK(q.cells == 64);
    CHECK(q.folded == 0);
    CHECK(q.extraordinary.empty());
    CHECK(q.min_angle.worst == Approx(M_PI_2).margin(1e-9));
    CHECK(q.skewness.worst == Approx(0.0).margin(1e-9));
    CHECK(q.aspect.worst == Approx(1.0).margin(0.1));
    CHECK(q.orthogonality.worst == Approx(0.0).margin(1e-9));
    // A smooth cube: corners of valence 3, 120 degrees by symmetry and cells alike.
    const Plan cube = grid::make_plan(grid::make_layout(test::cube(2.0)), {.cells = 64});
    const auto c = grid::measure_quality(grid::SurfaceGrid(cube));
    CHECK(c.interfaces == 12);
    CHECK(c.points == 6 * 65 * 65);
    CHECK(c.folded == 0);
    REQUIRE(c.extraordinary.size() == 8);
    for (const auto& v : c.extraordinary) {
        CHECK(v.cells == 3);
        CHECK(v.min_angle_rad == Approx(2 * M_PI / 3).margin(0.02));
        CHECK(v.max_angle_rad == Approx(v.min_angle_rad).margin(1e-9));
        CHECK(v.size_ratio == Approx(1.0).margin(1e-9));
    }
    CHECK(c.jump.worst == Approx(1.0).margin(1e-9));
}

TEST_CASE("grids are the same for any number of threads", "[grid]") {
    const BlockLayout layout = grid::make_layout(test::sample_cage("cages/genus2.obj"));
    std::vector<BlockPoints> before;
    for (const int threads : {1, 2, 0}) {
        base::set_thread_count(threads);
        const Plan plan = grid::make_plan(layout, {.cells = 150, .law = grid::Law::Cosine});
        const grid::BlockEvaluator evaluator(plan);
        for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
            const BlockPoints p = evaluator.evaluate(int(b));
            if (before.size() < layout.blocks.size()) {
                before.push_back(p);
            } else {
                CHECK(before[b].coordinates == p.coordinates);
            }
        }
    }
    base::set_thread_count(0);
}

}  // namespace
}  // namespace patchwright
