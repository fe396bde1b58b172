#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/crease_rule.h>
#include <patchwright/measure/fairness.h>

#include <catch2/catch.hpp>

using namespace patchwright;

namespace {

// Corners: else the surface has no tangent plane at a grid's ends.
const mesh::TopologyInput corners{.boundary_rule = mesh::BoundaryRule::EdgeAndCorner};

}  // namespace

TEST_CASE("a plane grid is fair and even", "[fit][oracle]") {
    const measure::Fairness f = measure::measure_fairness(test::grid(5, 4, corners));
    CHECK(f.curvature_variation < 1e-10);
    CHECK(f.skew < 1e-12);
    CHECK(f.least_angle_rad == Approx(M_PI / 2));
    // The faces at a boundary are as wide as the others: natural ends of uniform splines.
    CHECK(f.uneven_spacing < 1e-12);
}

TEST_CASE("a sheared, stretched grid has the skew and spacing of its making", "[fit][oracle]") {
    mesh::Cage cage = test::grid(6, 3, corners);
    cage.points.col(0) += cage.points.col(1);  // isolines at 45 degrees
    const measure::Fairness f = measure::measure_fairness(cage);
    CHECK(f.skew == Approx(std::sqrt(0.5)));
    CHECK(f.least_angle_rad == Approx(M_PI / 4));
    mesh::Cage stretched = test::grid(6, 3, corners);
    for (auto& x : stretched.points.col(0)) x = std::pow(2.0, x);
    // Inside, each face is twice as long as the one before along u, all are equal along v.
    const double spacing = measure::measure_fairness(stretched).uneven_spacing;
    CHECK(spacing > 0.4);
    CHECK(spacing < 1.0);
}

TEST_CASE("curvature variation sees bumps, whatever the size", "[fit][oracle]") {
    const mesh::Cage torus = test::torus(24, 16, 3.0, 1.0);
    mesh::Cage bumpy = torus;
    bumpy.points.row(40) *= 1.02;
    const double fair = measure::measure_fairness(torus).curvature_variation;
    CHECK(measure::measure_fairness(bumpy).curvature_variation > 1.5 * fair);
    mesh::Cage large = torus;
    large.points *= 1000.0;
    CHECK(measure::measure_fairness(large).curvature_variation == Approx(fair));
    CHECK_THROWS_AS(measure::measure_fairness(torus, 2), base::InvalidArgument);
}

TEST_CASE("the rule at creases moves the surface by what its ends differ", "[measure][oracle]") {
    mesh::TopologyInput runouts = corners;
    runouts.crease_rule = mesh::CreaseRule::ParabolicRunout;
    mesh::Cage cage = test::grid(6, 6, runouts);
    CHECK(measure::distance_from_catmull_clark(cage) < 1e-14);  // the plane
    // A control point next to the border, by `rise` at (3, 1): the line's end moves by 2/7, and the
    // point beyond by -8/7. At (3, u) the limit along v is 4/6 of that, and along u the cubic basis
    // of both; of five points a face, u = 1/2 is the largest.
    constexpr double rise = 1e-6;  // normals stay upright to 1e-12
    cage.points(3 * 7 + 1, 2) = rise;
    const double u = 0.5;
    const double moved = 2.0 / 7.0 * (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0 -
                         8.0 / 7.0 * (1.0 - u) * (1.0 - u) * (1.0 - u) / 6.0;
    CHECK(measure::distance_from_catmull_clark(cage) ==
          Approx(4.0 / 6.0 * rise * std::abs(moved)).epsilon(1e-9));
    cage.topology =
        std::make_shared<const mesh::Topology>(cage.topology->with(mesh::CreaseRule::CatmullClark));
    CHECK(measure::distance_from_catmull_clark(cage) == 0.0);
}
