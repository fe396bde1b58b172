#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/evaluate.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/limit_mask.h>

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

TEST_CASE("points of a moved plan are limit points of their places on the moved cage",
          "[grid][oracle]") {
    const auto sample = [](const char* name) {
        return mesh::read_obj(std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / name).cage;
    };
    // fan(5) and the dish are no quads: their layouts are of the first refinement.
    for (const mesh::Cage& cage : {test::torus(8, 6, 3.0, 1.0), test::fan(5),
                                   sample("wing/wing_cage.obj"), sample("cages/dish.obj")}) {
        const Plan plan = grid::make_plan(grid::make_layout(cage), {.cells = 5});
        geom::Points points = cage.points;
        points.col(2) += (0.3 * points.col(0)).array().sin().matrix() + 0.1 * points.col(1);
        const Plan moved = grid::with_points(plan, points);
        REQUIRE(moved.edges.size() == plan.edges.size());
        for (std::size_t e = 0; e < plan.edges.size(); ++e)
            CHECK(moved.edges[e].parameters == plan.edges[e].parameters);
        const grid::BlockEvaluator evaluator(moved);
        const subd::LimitEvaluator limit(cage.topology);
        const double size = geom::bounding_box(points).diagonal();
        for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
            const BlockPoints p = evaluator.evaluate(int(b));
            grid::BlockPlaces places;
            evaluator.places(int(b), places);
            for (std::size_t n = 0; n < p.count(); ++n) {
                const subd::Location at{mesh::FaceId{places.faces[n]}, places.u[n], places.v[n],
                                        places.sectors.empty() ? 0 : places.sectors[n]};
                const int ni = p.ni;
                // Rounding of parameters, as in the test of a plan's own points.
                CHECK((p.at(int(n) % ni, int(n) / ni) - limit.position(points, at)).norm() <
                      1e-11 * size);
            }
        }
        CHECK_THROWS_AS(grid::with_points(plan, points.topRows(3)), base::InvalidArgument);
    }
}

}  // namespace
}  // namespace patchwright
