// Foot points by the kernel's extrema beside those of the search.
#include "occ/foot_point_oracle.h"

#include <patchwright/base/parallel.h>
#include <patchwright/fit/fit.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

#include <filesystem>

using namespace patchwright;

namespace {

const std::filesystem::path wing_folder = std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / "wing";

const occ::CadReference& wing_reference(occ::FootPoints foot_points) {
    static const occ::CadModel model = occ::read_cad(wing_folder / "wing.igs").model;
    static const occ::CadReference search(model);
    static const occ::CadReference kernel(model, {.foot_points = occ::FootPoints::Kernel});
    return foot_points == occ::FootPoints::Kernel ? kernel : search;
}

geom::Points points_of(const std::vector<test::OracleQuery>& queries) {
    geom::Points points(Eigen::Index(queries.size()), 3);
    for (std::size_t i = 0; i < queries.size(); ++i)
        points.row(Eigen::Index(i)) = queries[i].point.transpose();
    return points;
}

}  // namespace

TEST_CASE("the kernel's foot points of the sample wing are those of the search", "[occ][oracle]") {
    const occ::CadReference& search = wing_reference(occ::FootPoints::Search);
    const occ::CadReference& kernel = wing_reference(occ::FootPoints::Kernel);
    const double limit = 1e-9 * search.bounds().diagonal();
    const auto queries = test::oracle_queries(search, 3000, 7);
    const geom::Points points = points_of(queries);
    const auto a = search.foot_points(points), b = kernel.foot_points(points);
    double apart = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(queries[i].kind, queries[i].point.transpose());
        CHECK(std::abs(a[i].distance - b[i].distance) <= limit);
        CHECK(std::abs((b[i].point - queries[i].point).norm() - b[i].distance) <= limit);
        // Far from the model, or between its sides, two points may be equally near.
        if (queries[i].kind == "on") apart = std::max(apart, (a[i].point - b[i].point).norm());
    }
    CHECK(apart <= limit);
}

TEST_CASE("the kernel's foot points face the side asked for", "[occ][oracle]") {
    const occ::CadReference& search = wing_reference(occ::FootPoints::Search);
    const occ::CadReference& kernel = wing_reference(occ::FootPoints::Kernel);
    const double limit = 1e-9 * search.bounds().diagonal();
    int turned = 0, compared = 0;
    for (const geom::SurfaceSample& sample : search.sample(300)) {
        if (sample.normal.isZero(0.0) || sample.weight == 0.0) continue;
        for (const double sign : {1.0, -1.0}) {
            const geom::Vec3 side = sign * sample.normal;
            const geom::Vec3 query = sample.point + 1e-3 * side;
            const geom::FootPoint a = search.foot_point(query, side);
            const geom::FootPoint b = kernel.foot_point(query, side);
            CAPTURE(query.transpose(), side.transpose());
            CHECK(std::abs(a.distance - b.distance) <= limit);
            CHECK((a.normal.dot(side) > 0.0) == (b.normal.dot(side) > 0.0));
            ++compared;
            turned += sign < 0.0 && b.normal.dot(side) > 0.0 ? 1 : 0;
        }
    }
    CHECK(compared > 300);
    CHECK(turned > 10);  // the other side of the thin part
}

TEST_CASE("the kernel's foot points have the same bits with any number of threads", "[occ]") {
    const occ::CadReference& kernel = wing_reference(occ::FootPoints::Kernel);
    const geom::Points points = points_of(test::oracle_queries(kernel, 1200, 8));
    base::set_thread_count(1);
    const auto one = kernel.foot_points(points);
    base::set_thread_count(2);
    const auto two = kernel.foot_points(points);
    base::set_thread_count(0);
    for (std::size_t i = 0; i < one.size(); ++i) {
        CHECK(one[i].point == two[i].point);
        CHECK(one[i].uv == two[i].uv);
        CHECK(one[i].face == two[i].face);
    }
}

TEST_CASE("a fit by the kernel's foot points comes to the same figures", "[occ][oracle]") {
    const mesh::Cage cage = mesh::read_obj(wing_folder / "wing_cage.obj").cage;
    const double size = wing_reference(occ::FootPoints::Search).bounds().diagonal();
    const fit::FitOptions options{.tolerance_mm = 1e-6 * size,
                                  .max_levels = 0,
                                  .reverse_samples = 1000,
                                  .solver = {.max_projections = 2, .samples_per_edge = 2}};
    const auto a = fit::fit(cage, wing_reference(occ::FootPoints::Search), options);
    const auto b = fit::fit(cage, wing_reference(occ::FootPoints::Kernel), options);
    REQUIRE(a.levels.size() == b.levels.size());
    for (std::size_t i = 0; i < a.levels.size(); ++i) {
        CHECK(a.levels[i].projections == b.levels[i].projections);
        CHECK(std::abs(a.levels[i].max_mm - b.levels[i].max_mm) <= 1e-9 * size);
        CHECK(std::abs(a.levels[i].rms_mm - b.levels[i].rms_mm) <= 1e-9 * size);
    }
    CHECK(a.cage.points.rows() == b.cage.points.rows());
}
