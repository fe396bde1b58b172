#include "support/cages.h"

#include <patchwright/adapt/local_grid.h>
#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace patchwright {
namespace {

using adapt::LocalCell;
using adapt::LocalGrid;
using geom::Vec3;
using grid::Plan;

/// Small at one point, growing with the distance.
adapt::SizeField graded(const Vec3& centre, double small, double growth, double reach) {
    std::vector<Vec3> at{centre};
    std::vector<double> sizes{small};
    for (double r = 0.05 * reach; r < 2.0 * reach; r *= 1.2) {
        for (int k = 0; k < 300; ++k) {
            const double z = 1.0 - (2.0 * k + 1.0) / 300.0, angle = 2.39996 * k;
            const double x = std::sqrt(1.0 - z * z);
            at.push_back(centre + r * Vec3(x * std::cos(angle), x * std::sin(angle), z));
            sizes.push_back(small + growth * r);
        }
    }
    geom::Points points(Eigen::Index(at.size()), 3);
    for (std::size_t i = 0; i < at.size(); ++i) points.row(Eigen::Index(i)) = at[i].transpose();
    return {points, sizes};
}

std::vector<int> polygon(const LocalCell& cell) {
    std::vector<int> corners;
    for (std::size_t k = 0; k < 4; ++k) {
        corners.push_back(cell.corners[k]);
        if (cell.hanging[k] >= 0) corners.push_back(cell.hanging[k]);
    }
    return corners;
}

struct Edges {
    std::map<std::pair<int, int>, int> halves;  ///< times that a side runs from one to the other
    int count = 0;
};

Edges edges_of(const LocalGrid& grid) {
    Edges edges;
    std::set<std::pair<int, int>> both;
    for (const LocalCell& cell : grid.cells) {
        const std::vector<int> p = polygon(cell);
        for (std::size_t k = 0; k < p.size(); ++k) {
            const int a = p[k], b = p[(k + 1) % p.size()];
            ++edges.halves[{a, b}];
            both.insert(std::minmax(a, b));
        }
    }
    edges.count = int(both.size());
    return edges;
}

/// Every side of a polygon has one neighbour the other way round, or is where the surface ends:
/// watertight, and with at most one hanging node a side 2:1. Then Euler's formula.
void check_topology(const LocalGrid& grid, int euler) {
    const Edges edges = edges_of(grid);
    std::set<std::pair<int, int>> free;
    for (const auto& [a, b] : grid.free_sides) free.insert({a, b});
    int wrong = 0;
    for (const auto& [side, times] : edges.halves) {
        const bool has_other = edges.halves.count({side.second, side.first}) > 0;
        if (times != 1 || has_other == (free.count(side) > 0)) ++wrong;
    }
    CHECK(wrong == 0);
    std::set<int> used;
    for (const LocalCell& cell : grid.cells)
        for (const int p : polygon(cell)) used.insert(p);
    CHECK(int(used.size()) == grid.points.rows());
    CHECK(int(used.size()) - edges.count + int(grid.cells.size()) == euler);
    // No two points at one place.
    std::set<std::array<double, 3>> places;
    for (Eigen::Index i = 0; i < grid.points.rows(); ++i)
        places.insert({grid.points(i, 0), grid.points(i, 1), grid.points(i, 2)});
    CHECK(Eigen::Index(places.size()) == grid.points.rows());
}

void check_places(const LocalGrid& grid, const mesh::Cage& cage) {
    const subd::LimitEvaluator limit(cage.topology);
    double worst = 0.0;
    for (Eigen::Index i = 0; i < grid.points.rows(); ++i) {
        const auto n = std::size_t(i);
        const subd::Location at{mesh::FaceId{grid.places.faces[n]}, grid.places.u[n],
                                grid.places.v[n],
                                grid.places.sectors.empty() ? 0 : grid.places.sectors[n]};
        worst = std::max(worst,
                         (limit.position(cage.points, at).transpose() - grid.points.row(i)).norm());
    }
    CHECK(worst <= 1e-12 * geom::bounding_box(cage.points).diagonal());
}

double longest_for_its_size(const LocalGrid& grid, const adapt::SizeField& sizes) {
    double worst = 0.0;
    for (const LocalCell& cell : grid.cells) {
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3 a = grid.points.row(cell.corners[k]);
            const Vec3 b = grid.points.row(cell.corners[(k + 1) % 4]);
            worst = std::max(worst, (b - a).norm() / sizes(0.5 * (a + b)));
        }
    }
    return worst;
}

double area(const LocalGrid& grid) {
    double sum = 0.0;
    for (const LocalCell& cell : grid.cells) {
        const std::vector<int> p = polygon(cell);
        for (std::size_t k = 2; k < p.size(); ++k) {
            const Vec3 a = grid.points.row(p[0]), b = grid.points.row(p[k - 1]),
                       c = grid.points.row(p[k]);
            sum += 0.5 * (b - a).cross(c - a).norm();
        }
    }
    return sum;
}

TEST_CASE("cells divided where sizes ask meet edge to edge, on surfaces of any topology",
          "[adapt][oracle]") {
    const std::filesystem::path samples = PATCHWRIGHT_SAMPLES_DIR;
    struct Case {
        mesh::Cage cage;
        bool join;
        int cells, euler;
    };
    const Case cases[] = {{test::cube(2.0), false, 4, 2},
                          {test::torus(8, 6, 3.0, 1.0), true, 5, 0},
                          {mesh::read_obj(samples / "cages/genus2.obj").cage, true, 2, -2},
                          {mesh::read_obj(samples / "cages/dish.obj").cage, false, 3, 1}};
    for (const Case& c : cases) {
        grid::BlockLayout layout = grid::make_layout(c.cage);
        if (c.join) layout = grid::join_all(layout);
        const Plan plan = grid::make_plan(layout, {.cells = c.cells});
        const double diagonal = geom::bounding_box(c.cage.points).diagonal();
        // Around a corner of blocks.
        const Vec3 centre = plan.edges[0].points.row(0);
        const adapt::SizeField sizes = graded(centre, 0.004 * diagonal, 0.2, diagonal);
        const LocalGrid fine = adapt::refined_locally(plan, {.sizes = sizes});
        CHECK(fine.deepest() >= 3);
        CHECK(fine.hanging_nodes() > 20);
        check_topology(fine, c.euler);
        check_places(fine, c.cage);
        // Middles by parameters, where sizes are asked for, are not quite those of sides, and
        // sizes that follow each other differ by 1.2.
        CHECK(longest_for_its_size(fine, sizes) <= 1.25);
    }
}

TEST_CASE("a small place costs fewer cells than whole lines around the body", "[adapt]") {
    const Plan plan = grid::make_plan(grid::make_layout(test::cube(2.0)), {.cells = 4});
    const adapt::SizeField sizes =
        graded(grid::BlockEvaluator(plan).evaluate(0).at(1, 2), 0.002, 0.3, 3.0);
    const LocalGrid local = adapt::refined_locally(plan, {.sizes = sizes});
    CHECK(std::int64_t(local.cells.size()) <
          adapt::refined(plan, {.sizes = sizes}).cell_count() / 2);
}

TEST_CASE("one size everywhere divides every cell equally often", "[adapt][oracle]") {
    const grid::BlockLayout layout = grid::make_layout(test::cube(2.0));
    const Plan plan = grid::make_plan(layout, {.cells = 3});
    double longest = 0.0, shortest = 1e9;
    for (const grid::EdgePoints& edge : plan.edges)
        for (Eigen::Index k = 0; k + 1 < edge.points.rows(); ++k) {
            const double length = (edge.points.row(k + 1) - edge.points.row(k)).norm();
            longest = std::max(longest, length);
            shortest = std::min(shortest, length);
        }
    geom::Points one(1, 3);
    one.setZero();
    // Longer than nothing: as it was.
    const LocalGrid same =
        adapt::refined_locally(plan, {.sizes = adapt::SizeField(one, {100.0 * longest})});
    CHECK(same.deepest() == 0);
    CHECK(same.hanging_nodes() == 0);
    CHECK(std::int64_t(same.cells.size()) == plan.cell_count());
    check_topology(same, 2);
    double before = 0.0;
    for (const int level : {0, 1, 2, 3}) {
        const LocalGrid fine = adapt::refined_locally(
            plan, {.sizes = adapt::SizeField(one, {0.1 * shortest})}, {.max_rounds = level});
        CHECK(fine.hanging_nodes() == 0);
        CHECK(std::int64_t(fine.cells.size()) == plan.cell_count() << (2 * level));
        // V - E + F = 2 with 4 F = 2 E.
        CHECK(std::int64_t(fine.points.rows()) == std::int64_t(fine.cells.size()) + 2);
        CHECK(area(fine) > before);  // of chords of a convex surface
        before = area(fine);
    }
    // As fine whole lines.
    const adapt::SizeField half(one, {0.3 * shortest});
    const Plan lines = adapt::refined(plan, {.sizes = half});
    const LocalGrid local = adapt::refined_locally(plan, {.sizes = half});
    double of_lines = 0.0;
    const grid::BlockEvaluator evaluator(lines);
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        const grid::BlockPoints p = evaluator.evaluate(int(b));
        for (int j = 0; j + 1 < p.nj; ++j)
            for (int i = 0; i + 1 < p.ni; ++i) {
                const Vec3 a = p.at(i, j), c = p.at(i + 1, j + 1);
                of_lines += 0.5 * (p.at(i + 1, j) - a).cross(c - a).norm() +
                            0.5 * (c - a).cross(p.at(i, j + 1) - a).norm();
            }
    }
    CHECK(area(local) == Approx(of_lines).epsilon(2e-3));
}

TEST_CASE("blocks that meet themselves, one cell around", "[adapt]") {
    // Edges, not pairs of points, tell sides apart here.
    const grid::BlockLayout layout = grid::join_all(grid::make_layout(test::torus(8, 6, 3.0, 1.0)));
    geom::Points one(1, 3);
    one << 4.0, 0.0, 0.0;
    for (const int cells : {1, 2}) {
        const Plan plan = grid::make_plan(layout, {.cells = cells});
        const LocalGrid fine =
            adapt::refined_locally(plan, {.sizes = graded(one.row(0).transpose(), 0.05, 0.2, 8.0)});
        check_topology(fine, 0);
        check_places(fine, test::torus(8, 6, 3.0, 1.0));
        CHECK(fine.hanging_nodes() > 10);
    }
}

TEST_CASE("wrong criteria and cancelling", "[adapt]") {
    const Plan plan = grid::make_plan(grid::make_layout(test::cube(2.0)), {.cells = 4});
    CHECK_THROWS_AS(adapt::refined_locally(plan, {}), base::InvalidArgument);
    geom::Points one(1, 3);
    one.setZero();
    CHECK_THROWS_AS(
        adapt::refined_locally(plan, {.sizes = adapt::SizeField(one, {0.001})},
                               {.progress = [](std::string_view, double) { return false; }}),
        base::Cancelled);
}

}  // namespace
}  // namespace patchwright
