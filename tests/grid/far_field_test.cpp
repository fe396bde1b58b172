#include "grid/sample_cage.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/layers.h>
#include <patchwright/grid/quality.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <limits>

namespace patchwright {
namespace {

using Catch::Matchers::Contains;
using grid::LayerGrid;
using grid::LayerOptions;
using grid::Plan;

/// A cube without the face at the lowest z: its border lies in a plane, and it stands on that.
mesh::Cage open_cube(double edge) {
    const mesh::Cage closed = test::cube(edge);
    std::vector<geom::Vec3> points;
    for (Eigen::Index p = 0; p < closed.points.rows(); ++p)
        points.emplace_back(closed.points.row(p));
    std::vector<std::vector<int>> faces = test::cube_faces;
    const auto is_low = [&](const std::vector<int>& face) {
        return std::all_of(face.begin(), face.end(),
                           [&](int p) { return points[std::size_t(p)].z() < 0.0; });
    };
    faces.erase(std::find_if(faces.begin(), faces.end(), is_low));
    return test::make_cage(points, faces);
}

Plan plan_of(const mesh::Cage& cage, double size_share) {
    const double diagonal = geom::bounding_box(cage.points).diagonal();
    return grid::make_plan(grid::make_layout(cage), {.size_mm = size_share * diagonal});
}

/// Layers and a far field of 20 diagonals; distances of the last layer from the middle.
struct Checked {
    grid::GridQuality quality;
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
};

Checked check_far_field(const Plan& plan, const geom::Vec3& middle, const LayerOptions& options) {
    LayerOptions without = options;
    without.far_field_mm = 0.0;
    const LayerGrid layers(plan, without), far(plan, options);
    CHECK(far.has_far_field());
    CHECK(far.layers() > layers.layers());
    CHECK(far.thinnest() == layers.thinnest());
    Checked result{grid::measure_quality(far)};
    for (int b = 0; b < far.block_count(); ++b) {
        grid::BlockPoints below, all;
        layers.evaluate(b, below);
        far.evaluate(b, all);
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(std::equal(below.coordinates[c].begin(), below.coordinates[c].end(),
                             all.coordinates[c].begin()));
        for (int j = 0; j < all.nj; ++j)
            for (int i = 0; i < all.ni; ++i) {
                const double distance = (all.at(i, j, all.nk - 1) - middle).norm();
                result.nearest = std::min(result.nearest, distance);
                result.farthest = std::max(result.farthest, distance);
            }
    }
    return result;
}

TEST_CASE("far fields end on a sphere, without folded cells", "[grid]") {
    const auto check = [](const mesh::Cage& cage, double size_share, double least) {
        const Plan plan = plan_of(cage, size_share);
        const double diagonal = geom::bounding_box(cage.points).diagonal();
        // The middle of what the grid's points take up, as documented.
        geom::Box3 box;
        grid::BlockPoints points;
        for (int b = 0; b < int(plan.layout.blocks.size()); ++b) {
            grid::SurfaceGrid(plan).evaluate(b, points);
            for (int j = 0; j < points.nj; ++j)
                for (int i = 0; i < points.ni; ++i) box.add(points.at(i, j));
        }
        const Checked far = check_far_field(plan, box.centre(),
                                            {.cells = 8,
                                             .growth = 1.3,
                                             .first_mm = 1e-3 * diagonal,
                                             .far_field_mm = 20.0 * diagonal});
        CAPTURE(far.quality.scaled_jacobian->at.transpose());
        CHECK(far.quality.negative == 0);
        CHECK(far.quality.scaled_jacobian->worst > least);
        CHECK(far.quality.scaled_jacobian->mean > 0.85);
        CHECK(far.nearest == Approx(20.0 * diagonal));
        CHECK(far.farthest == Approx(20.0 * diagonal));
    };
    check(test::cube(2.0), 0.06, 0.7);  // vertices of valence 3: corners of 120 degrees
    check(test::sample_cage("wing/wing_cage.obj"), 0.03, 0.02);
    check(test::sample_cage("wing_tip/cage.obj"), 0.04, 0.02);
    check(test::sample_cage("engine/cage.obj"), 0.05, 0.02);  // a duct that ends inside
}

TEST_CASE("far fields of surfaces that end in a plane are half spheres on it", "[grid]") {
    const mesh::Cage cage = open_cube(2.0);
    const Plan plan = plan_of(cage, 0.06);
    const double low = cage.points.col(2).minCoeff();
    const LayerOptions options{.cells = 6, .growth = 1.3, .first_mm = 0.01, .far_field_mm = 40.0};
    const Checked far = check_far_field(plan, {0.0, 0.0, low}, options);
    CHECK(far.quality.negative == 0);
    CHECK(far.quality.scaled_jacobian->worst > 0.3);
    CHECK(far.nearest == Approx(40.0));
    CHECK(far.farthest == Approx(40.0));
    double lowest = 0.0;
    grid::BlockPoints points;
    const LayerGrid grid(plan, options);
    for (int b = 0; b < grid.block_count(); ++b) {
        grid.evaluate(b, points);
        const auto& z = points.coordinates[2];
        lowest = std::min(lowest, *std::min_element(z.begin(), z.end()));
    }
    CHECK(lowest == Approx(low).epsilon(1e-9));
}

TEST_CASE("far fields have the same bits with any number of threads", "[grid]") {
    const Plan plan = plan_of(test::cube(2.0), 0.1);
    const auto coordinates = [&](int threads) {
        base::set_thread_count(threads);
        const LayerGrid grid(plan, {.cells = 3, .first_mm = 0.01, .far_field_mm = 30.0});
        base::set_thread_count(0);
        grid::BlockPoints points;
        grid.evaluate(2, points);
        return points.coordinates;
    };
    CHECK(coordinates(1) == coordinates(2));
}

TEST_CASE("surfaces that one layer of blocks cannot join to a sphere are refused", "[grid]") {
    const auto refused = [](const mesh::Cage& cage, double radius_mm, const char* what) {
        const Plan plan = plan_of(cage, 0.1);
        const LayerOptions options{.cells = 2, .first_mm = 1e-3, .far_field_mm = radius_mm};
        CHECK_THROWS_WITH(LayerGrid(plan, options), Contains(what));
        CHECK_THROWS_AS(LayerGrid(plan, options), base::UsageError);
    };
    refused(test::torus(8, 6, 3.0, 1.0), 100.0, "has a handle");
    refused(test::grid(3, 3), 100.0, "ends elsewhere");  // lies in the plane of its border
    refused(test::cube(2.0), 0.5, "does not hold the layers");
    const Plan plan = plan_of(test::cube(2.0), 0.1);
    CHECK_THROWS_AS(LayerGrid(plan, {.cells = 2, .first_mm = 1e-3, .far_field_mm = -1.0}),
                    base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
