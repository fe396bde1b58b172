#include "fit/warp/lattice.h"
#include "fit/warp/registration.h"
#include "measure/limit_folds.h"
#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/fit/refit.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/QR>
#include <algorithm>

using namespace patchwright;
using fit::DisplacementBasis;
using geom::Points;
using geom::Vec3;

namespace {

/// Everything of a cage but its points.
std::string tags_of(const mesh::Cage& cage) {
    mesh::Cage without = cage;
    without.points.setZero();
    return mesh::obj_text(without);
}

mesh::Cage fitted(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  double tolerance) {
    const auto result = fit::fit(cage, reference, {.tolerance_mm = tolerance});
    REQUIRE(result.within_tolerance);
    return result.cage;
}

}  // namespace

TEST_CASE("lattices reproduce affine maps, which cost nothing", "[fit][oracle]") {
    const geom::Box3 box{Vec3(-1, 2, 0), Vec3(7, 5, 0.5)};
    Points points = Points::Random(4000, 3);
    for (int k = 0; k < 3; ++k)
        points.col(k) = box.centre()[k] + 0.5 * (box.max[k] - box.min[k]) * points.col(k).array();
    const DisplacementBasis affine = DisplacementBasis::affine(box);
    REQUIRE(affine.size() == 4);
    const Points field = affine.values(points) * Points::Random(4, 3);
    for (const int cells : {1, 2, 4}) {
        const DisplacementBasis lattice = DisplacementBasis::lattice(box, cells);
        const Eigen::MatrixXd values = lattice.values(points);
        CHECK((values.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-12);
        const Points coefficients = values.colPivHouseholderQr().solve(field);
        CHECK((values * coefficients - field).cwiseAbs().maxCoeff() < 1e-9);
        // Zero but for rounding: of sums whose parts are as large as this, some hundred of 2e-16.
        const Eigen::MatrixXd stiffness = lattice.stiffness();
        const double parts = stiffness.norm() * coefficients.squaredNorm();
        CHECK((coefficients.transpose() * stiffness * coefficients).norm() < 1e-13 * parts);
    }
}

TEST_CASE("a cage that lies on the shape is not carried", "[fit][oracle]") {
    const test::Torus torus(3.0, 1.0);
    const mesh::Cage cage = fitted(test::torus(16, 10, 3.0, 1.0), torus, 1e-3);
    const auto result = fit::refit(cage, torus, {.fit = {.tolerance_mm = 1e-3}});
    CHECK(result.stages.empty());
    CHECK(result.carried_mm == 0.0);
    CHECK(result.fit.within_tolerance);
    CHECK((result.fit.cage.points - cage.points).rowwise().norm().maxCoeff() < 1e-2);
}

TEST_CASE("a fitted torus is carried to one of other radii", "[fit][oracle]") {
    const mesh::Cage cage = fitted(test::torus(24, 16, 3.0, 1.0), test::Torus(3.0, 1.0), 1e-3);
    for (const auto& [major, minor] : {std::pair{3.6, 1.0}, {3.0, 0.7}, {2.5, 1.3}, {3.5, 1.2}}) {
        INFO(major << ", " << minor);
        const test::Torus changed(major, minor);
        const auto result = fit::refit(cage, changed, {.fit = {.tolerance_mm = 2e-3}});
        CHECK(result.fit.within_tolerance);
        CHECK(result.fit.cage.topology == cage.topology);
        CHECK(result.fit.levels.size() == 1);
        const auto folded = measure::folded_samples(result.fit.cage, changed, 2e-3);
        CHECK(std::count(folded.begin(), folded.end(), 0) == int(folded.size()));
        CHECK(tags_of(result.fit.cage) == tags_of(cage));
    }
}

TEST_CASE("an affine change is carried by the affine map alone", "[fit][oracle]") {
    mesh::TopologyInput tags;
    for (int i = 0; i < 8; ++i)
        for (int axis = 0; axis < 3; ++axis)
            if ((i >> axis & 1) == 0)
                tags.creases.push_back({i, i | 1 << axis, mesh::infinite_sharpness});
    const mesh::Cage cage = test::cube(2.0, tags);
    const Vec3 changed(1.2, 0.8, 1.1);
    const auto carried = fit::registered(cage, test::Box(changed), {.tolerance_mm = 1e-4}, 2);
    REQUIRE(!carried.stages.empty());
    CHECK(carried.stages.front().cells == 0);
    CHECK(carried.stages.front().max_mm < 1e-4);
    const Points wanted = cage.points * changed.asDiagonal();
    CHECK((carried.cage.points - wanted).cwiseAbs().maxCoeff() < 1e-4);
}

TEST_CASE("pinned control points are not carried", "[fit]") {
    mesh::TopologyInput tags;
    tags.pins = {0, 7};
    const mesh::Cage cage = subd::refine(test::cube(2.0, tags), 1);
    const auto result = fit::refit(cage, test::Sphere(1.3), {.fit = {.tolerance_mm = 1e-4}});
    REQUIRE(!result.stages.empty());
    for (const mesh::VertexId v : cage.topology->vertices())
        if (cage.topology->is_pinned(v))
            CHECK(result.fit.cage.points.row(v.value) == cage.points.row(v.value));
}
