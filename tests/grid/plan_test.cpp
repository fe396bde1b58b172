#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/evaluate.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

namespace patchwright {
namespace {

using grid::BlockLayout;
using grid::BlockPoints;
using grid::Plan;

TEST_CASE("numbers of points match options and rules", "[grid]") {
    const BlockLayout layout = grid::make_layout(test::cube(2.0));
    const Plan plan = grid::make_plan(layout, {.cells = 10, .levels = 2});
    for (const auto& edge : plan.edges) CHECK(edge.cells() == 12);
    CHECK(plan.point_count() == 6 * 13 * 13);
    CHECK(plan.cell_count() == 6 * 12 * 12);
    const Plan ruled = grid::make_plan(
        layout, {.cells = 10, .rules = {{.edge = 0, .cells = 5, .law = grid::Law::Cosine}}});
    int five = 0;
    for (const auto& edge : ruled.edges) five += edge.cells() == 5 ? 1 : 0;
    CHECK(five == 4);  // the four parallel edges of a cube
    CHECK_THROWS_AS(grid::make_plan(layout, {.cells = 0}), base::InvalidArgument);
    CHECK_THROWS_AS(grid::make_plan(layout, {.size_mm = 1e-9}), base::InvalidArgument);
    CHECK_THROWS_AS(grid::make_plan(layout, {.clusters = {{"top", "", 0.1}}}),
                    base::InvalidArgument);
    CHECK_THROWS_AS(grid::make_plan(layout, {.rules = {{.edge = 99}}}), base::InvalidArgument);
}

TEST_CASE("a coarsened grid is every other point of the fine one", "[grid]") {
    const BlockLayout layout = grid::make_layout(
        mesh::read_obj(std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / "wing/wing_cage.obj").cage);
    const Plan fine = grid::make_plan(
        layout,
        {.size_mm = 100.0, .levels = 2, .law = grid::Law::Tanh, .first_at_creases_mm = 2.0});
    const Plan coarse = grid::coarsened(fine, 2);
    const grid::BlockEvaluator of_fine(fine), of_coarse(coarse);
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        const BlockPoints p = of_fine.evaluate(int(b)), q = of_coarse.evaluate(int(b));
        REQUIRE(p.ni - 1 == 4 * (q.ni - 1));
        REQUIRE(p.nj - 1 == 4 * (q.nj - 1));
        for (int i = 0; i < q.ni; ++i) {
            for (int j = 0; j < q.nj; ++j) {
                CHECK((q.at(i, j).array() == p.at(4 * i, 4 * j).array()).all());
            }
        }
    }
    CHECK_THROWS_AS(grid::coarsened(fine, 16), base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
