#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/modes.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

using namespace patchwright;
using geom::Points;

namespace {

double largest_entry(const Points& points) { return points.cwiseAbs().maxCoeff(); }

/// Members that differ by two fields of displacement, neither of which is a mode by itself.
std::vector<Points> two_dimensional_family(const mesh::Cage& cage) {
    const Points first = Points::Random(cage.points.rows(), 3);
    const Points second = Points::Random(cage.points.rows(), 3);
    std::vector<Points> members;
    for (const auto& [a, b] : {std::pair{0.0, 0.0}, {1.0, 0.5}, {-0.3, 2.0}, {0.7, -1.0}})
        members.push_back(cage.points + a * first + b * second);
    return members;
}

}  // namespace

TEST_CASE("the mode of shifted shapes is the shift, its weights are the distances",
          "[fit][oracle]") {
    const mesh::Cage cage = test::random_cage(2);
    const std::vector<double> shifts{-4.0, 1.0, 3.0, 8.0};  // mean 2
    std::vector<Points> members;
    for (const double shift : shifts)
        members.push_back(cage.points.rowwise() + Eigen::RowVector3d(0.0, shift, 0.0));
    const fit::Modes modes = fit::principal_modes(cage.topology, members, 3);
    REQUIRE(modes.count() == 1);
    // Masks sum to 1 but for rounding.
    const Points up = Points::Zero(cage.points.rows(), 3).rowwise() + Eigen::RowVector3d(0, 1, 0);
    CHECK(largest_entry(modes.shapes[0] - up) < 1e-12);
    for (std::size_t i = 0; i < shifts.size(); ++i)
        CHECK(modes.weights(Eigen::Index(i), 0) == Approx(shifts[i] - 2.0).epsilon(1e-12));
    CHECK(modes.deviations_mm[0] == Approx(std::sqrt((36.0 + 1.0 + 1.0 + 36.0) / 4.0)));
    CHECK(modes.variance_mm2 == Approx(74.0 / 4.0));
}

TEST_CASE("as many modes as members differ by give the members again", "[fit][oracle]") {
    for (unsigned seed = 0; seed < 4; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage = test::random_cage(seed, {.open = seed % 2 == 1});
        const std::vector<Points> members = two_dimensional_family(cage);
        const fit::Modes modes = fit::principal_modes(cage.topology, members, 10);
        REQUIRE(modes.count() == 2);
        CHECK(modes.share(2) == Approx(1.0));
        CHECK(modes.share(1) < 1.0);
        CHECK(modes.deviations_mm[0] >= modes.deviations_mm[1]);
        for (std::size_t i = 0; i < members.size(); ++i)
            CHECK(largest_entry(fit::member(modes, modes.weights.row(Eigen::Index(i))) -
                                members[i]) < 1e-12);
        // Weights of different modes are uncorrelated, and sum to zero.
        const Eigen::MatrixXd products = modes.weights.transpose() * modes.weights;
        CHECK(std::abs(products(0, 1)) < 1e-12 * products(0, 0));
        CHECK(modes.weights.colwise().sum().cwiseAbs().maxCoeff() < 1e-12);
    }
}

TEST_CASE("modes are those of the surface, however dense its control points are", "[fit][oracle]") {
    const mesh::Cage cage = test::random_cage(4);
    const std::vector<Points> members = two_dimensional_family(cage);
    std::vector<Points> finer;
    mesh::Cage refined;
    for (const Points& points : members) {
        refined = subd::refine(mesh::Cage{cage.topology, points}, 1);
        finer.push_back(refined.points);
    }
    const fit::Modes coarse = fit::principal_modes(cage.topology, members, 2);
    const fit::Modes fine = fit::principal_modes(refined.topology, finer, 2);
    // The same surfaces; the elements of area are no polynomials, so quadrature differs.
    CHECK(fine.weights.isApprox(coarse.weights, 1e-3));
    for (std::size_t k = 0; k < 2; ++k) {
        const Points shape = subd::refine(mesh::Cage{cage.topology, coarse.shapes[k]}, 1).points;
        CHECK(largest_entry(fine.shapes[k] - shape) < 1e-3 * largest_entry(shape));
    }
}

TEST_CASE("members that are equal have no modes", "[fit]") {
    const mesh::Cage cage = test::random_cage(1);
    const fit::Modes modes =
        fit::principal_modes(cage.topology, {cage.points, cage.points, cage.points}, 2);
    CHECK(modes.count() == 0);
    CHECK(modes.share(0) == 1.0);
    CHECK(largest_entry(fit::member(modes, {}) - cage.points) < 1e-12);
}

TEST_CASE("what is no family has no modes", "[fit]") {
    const mesh::Cage cage = test::random_cage(1);
    CHECK_THROWS_AS(fit::principal_modes(cage.topology, {cage.points}, 1), base::InvalidArgument);
    CHECK_THROWS_AS(fit::principal_modes(cage.topology, {cage.points, cage.points}, 0),
                    base::InvalidArgument);
    CHECK_THROWS_AS(fit::principal_modes(cage.topology, {cage.points, cage.points.topRows(3)}, 1),
                    base::InvalidArgument);
    const fit::Modes modes =
        fit::principal_modes(cage.topology, {cage.points, 2.0 * cage.points}, 1);
    CHECK_THROWS_AS(fit::member(modes, Eigen::VectorXd::Zero(2)), base::InvalidArgument);
}
