#include "support/cages.h"

#include <patchwright/adapt/refinement.h>
#include <patchwright/base/error.h>
#include <patchwright/grid/evaluate.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

namespace patchwright {
namespace {

using geom::Vec3;
using grid::Plan;

TEST_CASE("cells are no longer than a field of sizes asks for, and not much shorter", "[grid]") {
    const Plan coarse =
        grid::make_plan(grid::make_layout(test::torus(8, 6, 3.0, 1.0)), {.cells = 2});
    const geom::Box3 box = geom::bounding_box(coarse.layout.cage.points);
    // Fine where x is low: sizes at the two ends.
    geom::Points at(2, 3);
    at.row(0) = box.min.transpose();
    at.row(1) = box.max.transpose();
    const double small = 0.02 * box.diagonal(), large = 0.1 * box.diagonal();
    const adapt::SizeField sizes(at, {small, large});
    CHECK(sizes(box.min) == small);
    CHECK(sizes(box.max) == large);
    const Plan fine = adapt::refined(coarse, {.sizes = sizes});
    const grid::BlockEvaluator evaluator(fine);
    double longest = 0.0, longest_large = 0.0;
    for (std::size_t b = 0; b < fine.layout.blocks.size(); ++b) {
        const grid::BlockPoints points = evaluator.evaluate(int(b));
        for (int j = 0; j < points.nj; ++j) {
            for (int i = 0; i + 1 < points.ni; ++i) {
                const geom::Vec3 p = points.at(i, j), q = points.at(i + 1, j);
                const double size = sizes(0.5 * (p + q));
                longest = std::max(longest, (q - p).norm() / size);
                if (size == large) longest_large = std::max(longest_large, (q - p).norm() / size);
            }
        }
    }
    CHECK(longest <= 1.02);  // the middle by parameters is not quite that of the chord
    CHECK(longest_large > 0.3);
    CHECK(fine.cell_count() > coarse.cell_count());
    CHECK(adapt::refined(fine, {.sizes = sizes}).cell_count() == fine.cell_count());
    // No smaller than what is said to be smallest.
    const double smallest = 0.05 * box.diagonal();
    const Plan bounded = adapt::refined(coarse, {.sizes = sizes, .smallest_mm = smallest});
    CHECK(bounded.cell_count() < fine.cell_count());
    CHECK_THROWS_AS(adapt::refined(coarse, {.sizes = sizes},
                                   {.progress = [](std::string_view, double) { return false; }}),
                    base::Cancelled);
    CHECK_THROWS_AS(adapt::refined(coarse, {}), base::InvalidArgument);
    CHECK_THROWS_AS(adapt::refined(coarse, {.sizes = sizes, .smallest_mm = -1.0}),
                    base::InvalidArgument);
}

/// Sides of all cells, along i and along j of their block.
template <class Visit>
void visit_sides(const Plan& plan, const Visit& visit) {
    const grid::BlockEvaluator evaluator(plan);
    for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
        const grid::BlockPoints points = evaluator.evaluate(int(b));
        for (int j = 0; j < points.nj; ++j)
            for (int i = 0; i < points.ni; ++i) {
                if (i + 1 < points.ni) visit(points.at(i, j), points.at(i + 1, j));
                if (j + 1 < points.nj) visit(points.at(i, j), points.at(i, j + 1));
            }
    }
}

/// Values of f at the points of a grid, as a solver has them that ran on it.
template <class Function>
adapt::Sensor solution(const Plan& plan, const Function& f) {
    std::vector<double> coordinates, values;
    const auto add = [&](const Vec3& p) {
        coordinates.insert(coordinates.end(), p.begin(), p.end());
        values.push_back(f(p));
    };
    visit_sides(plan, [&](const Vec3& a, const Vec3& b) {
        add(a);
        add(b);
    });
    return {Eigen::Map<geom::Points>(coordinates.data(), Eigen::Index(values.size()), 3),
            std::move(values)};
}

TEST_CASE("a quantity changes along no side by more than the share of its range",
          "[adapt][oracle]") {
    const grid::BlockLayout layout = grid::make_layout(test::torus(8, 6, 3.0, 1.0));
    const Plan start = grid::make_plan(layout, {.cells = 4});
    const auto f = [](const Vec3& p) { return p.x(); };
    const adapt::Sensor sensor = solution(grid::make_plan(layout, {.cells = 16}), f);
    for (const double jump : {0.1, 0.05}) {
        const Plan fine = adapt::refined(start, {.sensor = sensor, .sensor_jump = jump});
        double largest = 0.0;
        visit_sides(fine, [&](const Vec3& a, const Vec3& b) {
            largest = std::max(largest, std::abs(f(b) - f(a)) / sensor.range());
        });
        // The reconstruction is of the solver's points, not of f: good to a fifth here.
        CHECK(largest <= 1.2 * jump);
        CHECK(largest >= 0.4 * jump);
        CHECK(adapt::refined(fine, {.sensor = sensor, .sensor_jump = jump}).cell_count() ==
              fine.cell_count());
    }
    // What does not change asks for nothing.
    CHECK(adapt::refined(start, {.sensor = solution(start, [](const Vec3&) { return 2.0; })})
              .cell_count() == start.cell_count());
}

TEST_CASE("a shock is refined down to the smallest cell, and the rest is left", "[adapt]") {
    const grid::BlockLayout layout = grid::make_layout(test::cube(2.0));
    const Plan start = grid::make_plan(layout, {.cells = 8});
    const double middle = 0.03;
    const adapt::Sensor shock =
        solution(start, [&](const Vec3& p) { return p.x() < middle ? 1.0 : 2.0; });
    const double smallest = 0.01;
    const Plan fine = adapt::refined(start, {.sensor = shock, .smallest_mm = smallest});
    double least = 10.0, far = 0.0, across = 0.0;
    visit_sides(fine, [&](const Vec3& a, const Vec3& b) {
        const double length = (b - a).norm(), beside = std::abs(0.5 * (a + b).x() - middle);
        least = std::min(least, length);
        if (std::abs((b - a).x()) < 0.9 * length) return;
        if (beside > 0.6) far = std::max(far, length);
        if (beside < smallest) across = std::max(across, length);
    });
    CHECK(least >= 0.6 * smallest);  // other lines of a halved class are shorter than the longest
    CHECK(across <= 2.0 * smallest + 1e-12);
    double far_before = 0.0;
    visit_sides(start, [&](const Vec3& a, const Vec3& b) {
        if (std::abs((b - a).x()) >= 0.9 * (b - a).norm() &&
            std::abs(0.5 * (a + b).x() - middle) > 0.6)
            far_before = std::max(far_before, (b - a).norm());
    });
    CHECK(far == far_before);
}

}  // namespace
}  // namespace patchwright
