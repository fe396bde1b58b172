#include "fit/solve/regularisation.h"

#include "support/cages.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace patchwright;
using geom::Points;

namespace {

constexpr double scale = 0.1;

/// Lines that gather at one side, as at a leading edge.
mesh::Cage uneven_grid() {
    mesh::Cage cage = test::grid(6, 5);
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v)
        cage.points(v, 0) = std::pow(cage.points(v, 0), 2);
    return cage;
}

double largest(const fit::Regularisation& r, const Points& points, double bending,
               double tangential) {
    return r.changes(points, r.weights_at(points, bending, tangential)).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("A plane with uneven lines bends nothing, and its lines stay", "[fit][oracle]") {
    const mesh::Cage cage = uneven_grid();
    const auto kept = fit::Regularisation::of_surface(*cage.topology, cage.points, scale, false);
    // Second derivatives are up to 2, sums of some ten products.
    const double rounding = 1e-13;
    for (const double tangential : {0.0, 1.0}) {
        CHECK(largest(kept, cage.points, 1.0, tangential) < rounding);
        CHECK(kept.energy(cage.points, kept.weights_at(cage.points, 1.0, tangential)) <
              rounding * rounding * double(kept.rows().rows()));
    }
    SECTION("Lines that move within it come back") {
        Points moved = cage.points;
        moved.col(0) = moved.col(0).cwiseSqrt();
        CHECK(largest(kept, moved, 1.0, 0.0) > 1.0);
        CHECK(kept.energy(moved, kept.weights_at(moved, 1.0, 0.0)) > 1.0);
    }
    SECTION("Bending makes them even where it is asked to, as long as it has weight") {
        const auto evened =
            fit::Regularisation::of_surface(*cage.topology, cage.points, scale, true);
        CHECK(largest(evened, cage.points, 1.0, 1.0) > 1.0);
        CHECK(largest(evened, cage.points, 0.0, 1.0) < rounding);
    }
    SECTION("Without a parametrisation to keep, they become even") {
        const auto even = fit::Regularisation::of_surface(*cage.topology, cage.points, 0.0, false);
        CHECK(largest(even, cage.points, 1.0, 1.0) > 1.0);
    }
    SECTION("Where the given one is folded as well") {
        auto evened = fit::Regularisation::of_surface(*cage.topology, cage.points, scale, false);
        evened.even_out(12, scale);
        const Points changes =
            evened.changes(cage.points, evened.weights_at(cage.points, 1.0, 1.0));
        const auto& rows = evened.rows().site_rows();
        for (Eigen::Index i = 0; i < changes.rows(); ++i) {
            const bool is_evened = i >= rows[12] && i < rows[13];
            if (!is_evened) CHECK(changes.row(i).norm() < rounding);
        }
        CHECK(changes.middleRows(rows[12], rows[13] - rows[12]).cwiseAbs().maxCoeff() > 1.0);
    }
}

TEST_CASE("The energy of a regularisation is that of the changes it asks for", "[fit]") {
    mesh::Cage cage = uneven_grid();
    const bool evens_lines = GENERATE(false, true);
    const auto r = fit::Regularisation::of_surface(*cage.topology, cage.points, scale, evens_lines);
    // A bent surface with other lines: both parts count.
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v) {
        const double x = cage.points(v, 0), y = cage.points(v, 1);
        cage.points.row(v) << x + 0.1 * y * y, y + 0.05 * x, 0.2 * x * x - 0.1 * x * y;
    }
    const fit::RegularisationWeights weights = r.weights_at(cage.points, 0.3, 2.0);
    const Points changes = r.changes(cage.points, weights);
    double bending = 0.0, sliding = 0.0;
    for (Eigen::Index i = 0; i < changes.rows(); ++i) {
        const double across = changes.row(i).dot(weights.rows.direction.row(i));
        bending += std::pow(weights.rows.along * across, 2);
        sliding += std::pow(weights.rows.across_by_row[i], 2) *
                   (changes.row(i).squaredNorm() - across * across);
    }
    CHECK(bending > 0.0);
    CHECK(sliding > 0.0);
    CHECK(r.energy(cage.points, weights) == Approx(bending + sliding).epsilon(1e-12));
}
