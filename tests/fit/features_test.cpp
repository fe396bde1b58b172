#include "fit/feature_match.h"
#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

namespace {

mesh::Cage sharp_cube(double edge) {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] < face[(i + 1) % 4]) {
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
            }
        }
    }
    return test::cube(edge, tags);
}

/// A square plate whose upper rim is free and has corners.
class Plate final : public geom::ReferenceSurface {
  public:
    Plate() : features_(box_.features()) {
        for (geom::FeatureCurve& c : features_.curves) {
            const bool upper = c.start_corner >= 4 && c.end_corner >= 4;
            c.kind = upper ? geom::FeatureKind::Free : geom::FeatureKind::Smooth;
        }
    }
    geom::Box3 bounds() const override { return box_.bounds(); }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        Vec3 p = q.cwiseMax(-1).cwiseMin(1);
        p.z() = thickness;
        return {p, Vec3::UnitZ(), (q - p).norm(), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int curve, const Vec3& q, const std::optional<geom::ArcRange>& within) const override {
        return box_.nearest_on_curve(curve, q, within);
    }
    geom::FeaturePoint point_on_curve(int curve, double s) const override {
        return box_.point_on_curve(curve, s);
    }
    static constexpr double thickness = 1e-3;

  private:
    test::Box box_{Vec3(1, 1, thickness)};
    geom::Features features_;
};

fit::FeatureMatch match(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    const auto curves = fit::curve_sites(*cage.topology);
    const subd::LimitOperator limit(*cage.topology, fit::side_sets(4), curves.sites);
    geom::Points samples;
    limit.apply(cage.points, samples);
    return fit::match_features(*cage.topology, cage.points, curves, samples, 4, reference, 0.2);
}

double length(const fit::FeaturePath& path) {
    double sum = 0.0;
    for (const auto& piece : path) sum += piece.range.to - piece.range.from;
    return sum;
}

mesh::Cage square_grid(mesh::TopologyInput tags) {
    mesh::Cage cage = test::grid(4, 4, std::move(tags));
    cage.points = (cage.points.array() - 2.0) * 0.45;
    cage.points.col(2).setConstant(0.05);
    return cage;
}

}  // namespace

TEST_CASE("corners keep their order where the cage is off by more than a part is thick",
          "[fit][features]") {
    const Vec3 half(1.0, 1.0, 0.01);
    mesh::Cage cage = sharp_cube(2.0);
    cage.points.col(2) = 0.012 * cage.points.col(2).array() + 0.03;
    const auto result = fit::fit(cage, test::Box(half), {.tolerance_mm = 1e-9});
    CHECK(result.met);
    CHECK(result.levels.back().chains_on_features == 12);
    for (int v = 0; v < 8; ++v) {
        const Vec3 corner =
            half.cwiseProduct(Vec3(2 * (v & 1) - 1, 2 * (v >> 1 & 1) - 1, 2 * (v >> 2) - 1));
        CHECK((result.cage.points.row(v).transpose() - corner).norm() == 0.0);
    }
}

TEST_CASE("a boundary with corners takes one curve between two corners", "[fit][features]") {
    const mesh::Cage cage = square_grid({.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
    const auto found = match(cage, Plate());
    REQUIRE(found.paths.size() == 4);
    CHECK(found.places.size() == 4);
    for (const auto& path : found.paths) {
        CHECK(path.size() == 1);
        CHECK(length(path) == 2.0);
    }
}

TEST_CASE("a boundary without corners, or with one, goes all the way round", "[fit][features]") {
    const auto closed = match(square_grid({}), Plate());
    REQUIRE(closed.paths.size() == 1);
    CHECK(length(closed.paths[0]) == Approx(8.0));
    mesh::TopologyInput one;
    one.corners.push_back({0, mesh::infinite_sharpness});
    const auto loop = match(square_grid(one), Plate());
    REQUIRE(loop.paths.size() == 1);
    CHECK(length(loop.paths[0]) == Approx(8.0));
    REQUIRE(loop.places.size() == 1);
    CHECK(loop.places[0].point == Vec3(-1, -1, Plate::thickness));
}

TEST_CASE("a chain follows its own way though a shorter one joins its ends", "[fit][features]") {
    // Three sides of the rim from corner to corner; the fourth is the shorter way.
    mesh::TopologyInput two;
    two.corners = {{0, mesh::infinite_sharpness}, {4, mesh::infinite_sharpness}};
    const auto found = match(square_grid(two), Plate());
    REQUIRE(found.paths.size() == 2);
    CHECK(std::max(length(found.paths[0]), length(found.paths[1])) == Approx(6.0));
    CHECK(std::min(length(found.paths[0]), length(found.paths[1])) == Approx(2.0));
}

TEST_CASE("sharp edges that are far from every feature are fitted like the surface",
          "[fit][features]") {
    mesh::TopologyInput tags;
    for (int j = 0; j < 4; ++j) {
        tags.creases.push_back({10 + j, 11 + j, mesh::infinite_sharpness});
    }
    const auto found = match(square_grid(tags), Plate());
    int without = 0;
    for (const auto& path : found.paths) without += path.empty() ? 1 : 0;
    CHECK(without == 1);
}
