#include "fit/loop/former_surface.h"

#include "support/cages.h"

#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>

using namespace patchwright;
using geom::Vec3;

namespace {

/// A drum around z, from z = -1 to 1 and of 12 quads around, with or without lids of 12 more that
/// meet it at sharp edges.
mesh::Cage drum(bool lids) {
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces;
    mesh::TopologyInput tags;
    const int n = 12;
    const auto at = [&](int row, int i) { return row * n + i % n; };
    const auto ring = [&](double radius, double z) {
        for (int i = 0; i < n; ++i) {
            const double a = 2.0 * M_PI * i / n;
            points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
        }
    };
    if (lids) ring(0.5, -1.0);
    for (const double z : {-1.0, -0.5, 0.0, 0.5, 1.0}) ring(1.0, z);
    if (lids) ring(0.5, 1.0);
    const int rows = lids ? 7 : 5;
    for (int row = 0; row + 1 < rows; ++row)
        for (int i = 0; i < n; ++i)
            faces.push_back({at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
    if (lids)
        for (const int row : {1, 5})
            for (int i = 0; i < n; ++i) tags.creases.push_back({at(row, i), at(row, i + 1), 10.0});
    return test::make_cage(points, faces, tags);
}

}  // namespace

TEST_CASE("a disturbed cage returns to its limit surface and sharp curves", "[fit][oracle]") {
    for (const bool lids : {false, true}) {
        const mesh::Cage former = drum(lids);
        mesh::Cage cage = former;
        std::srand(5);
        cage.points += 0.05 * geom::Points::Random(cage.points.rows(), 3);
        fit::return_to(cage, former, {.tolerance_mm = 0.01});
        // Limit points of the wall are on the circle of cubic B-splines with 12 control points, of
        // radius (4 + 2 cos(30 degrees)) / 6 at the knots and 2e-4 less between them.
        const double radius = (4.0 + 2.0 * std::cos(M_PI / 6.0)) / 6.0;
        for (const mesh::VertexId v : cage.topology->vertices()) {
            const int row = v.value / 12 + (lids ? 0 : 1);
            if (row == 0 || row == 6) continue;
            const Vec3 at = subd::limit_position(cage, v);
            INFO("lids " << lids << ", vertex " << v.value << " at " << at.transpose());
            CHECK(std::abs(at.head<2>().norm() - radius) < 3e-3);
            if (row == 1 || row == 5) CHECK(std::abs(std::abs(at.z()) - 1.0) < 3e-3);
        }
    }
}

TEST_CASE("a cage that is on its former surface stays", "[fit]") {
    const mesh::Cage former = drum(true);
    mesh::Cage cage = subd::refine(former, 1);
    const geom::Points given = cage.points;
    fit::return_to(cage, former, {.tolerance_mm = 0.01});
    CHECK((cage.points - given).rowwise().norm().maxCoeff() < 1e-3);
}

TEST_CASE("samples in a fold are not drawn to the far side, which faces alike", "[fit]") {
    const mesh::Cage former = test::torus(12, 12, 3.0, 1.0);
    mesh::Cage cage = subd::refine(former, 1);
    const geom::Points given = cage.points;
    // Faces turn over where a vertex is moved beyond its neighbour.
    const mesh::Topology& t = *cage.topology;
    const mesh::EdgeId edge{7};
    const int moved = t.start(edge).value;
    cage.points.row(moved) += 4.0 * (given.row(t.end(edge).value) - given.row(moved));
    fit::return_to(cage, former, {.tolerance_mm = 0.01});
    for (const mesh::VertexId v : t.vertices()) {
        const Vec3 at = subd::limit_position(cage, v);
        const Vec3 was = subd::limit_position({cage.topology, given}, v);
        INFO("vertex " << v.value << " at " << at.transpose() << ", before " << was.transpose());
        CHECK((at - was).norm() < 0.4);  // the tube is 1.8 wide, sides of faces 0.3 and more
    }
}
