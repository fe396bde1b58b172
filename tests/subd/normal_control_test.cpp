#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <sstream>

using namespace patchwright;
using geom::Vec3;
using mesh::FaceId;

namespace {

/// An open fan of `faces` quads around vertex 0 that spans `degrees`, its vertex a corner; heights
/// of the other vertices are `bend` times a wave.
mesh::Cage open_fan(int faces, double degrees, double bend, bool tagged,
                    Vec3 normal = Vec3::Zero()) {
    std::vector<Vec3> points{Vec3::Zero()};
    std::vector<std::vector<int>> polygons;
    for (int k = 0; k <= 2 * faces; ++k) {
        const double a = degrees * M_PI / 180.0 * k / (2 * faces);
        const double r = k % 2 == 0 ? 1.0 : 1.3;
        points.emplace_back(r * std::cos(a), r * std::sin(a), bend * std::sin(2.0 * k + 0.3));
    }
    for (int k = 0; k < faces; ++k) polygons.push_back({0, 2 * k + 1, 2 * k + 2, 2 * k + 3});
    mesh::TopologyInput tags;
    tags.corners.push_back({0, mesh::infinite_sharpness});
    if (tagged) {
        tags.sectors.push_back(
            {0, 0, degrees * M_PI / 180.0, {normal.x(), normal.y(), normal.z()}});
    }
    return test::make_cage(points, polygons, std::move(tags));
}

/// The least cosine between `up` and normals in a small disk around vertex 0.
double least_cosine(const mesh::Cage& cage, int faces, const Vec3& up) {
    const subd::LimitEvaluator evaluator(cage.topology);
    double least = 1.0;
    for (int f = 0; f < faces; ++f) {
        for (const int level : {3, 8, 16}) {
            const double away = std::ldexp(1.0, -level);
            for (const auto& [u, v] :
                 {std::pair{1.0, 0.1}, {1.0, 0.5}, {1.0, 1.0}, {0.5, 1.0}, {0.1, 1.0}}) {
                const auto p = evaluator.evaluate(cage.points, {FaceId{f}, away * u, away * v}, 1);
                least = std::min(least, p.normal.dot(up));
            }
        }
    }
    return least;
}

}  // namespace

TEST_CASE("concave corners fold without control and do not with it", "[subd][oracle]") {
    for (const int faces : {2, 3, 4}) {
        for (const double degrees : {200.0, 270.0, 320.0}) {
            CAPTURE(faces, degrees);
            const Vec3 up(0, 0, 1);
            if (faces == 2 && degrees > 250.0) {
                CHECK(least_cosine(open_fan(faces, degrees, 0.0, false), faces, up) < 0.0);
            }
            const mesh::Cage flat = subd::control_normals(open_fan(faces, degrees, 0.0, true));
            CHECK(least_cosine(flat, faces, up) > 0.999999);
        }
    }
}

TEST_CASE("the edge between two quads at a corner turns by a sixth of the creases' sum a step",
          "[subd][oracle]") {
    // In units that halve with each step. With it two quads fold in every concave sector.
    const mesh::Cage fan = open_fan(2, 260.0, 0.0, false);
    const auto inner_edge = [&](int step) {
        const mesh::Cage fine = subd::refine(fan, step);
        const mesh::Topology& t = *fine.topology;
        for (const mesh::EdgeId e : t.edges()) {
            if (t.is_boundary(e)) continue;
            const Vec3 from = fine.points.row(t.start(e).value),
                       to = fine.points.row(t.end(e).value);
            if (from.isZero() || to.isZero()) return Vec3(std::ldexp(1.0, step) * (from + to));
        }
        return Vec3(Vec3::Zero());
    };
    const Vec3 sum = (fan.points.row(1) + fan.points.row(5)).transpose();
    CHECK((inner_edge(9) - inner_edge(8) - sum / 6.0).norm() < 1e-4);
}

namespace {

/// Three quads in a sector of 270 degrees whose inner edges are uneven, so that the part of the
/// control points that shrinks least points beyond a crease; a corner without tags. Slanted.
mesh::Cage uneven_sector() {
    const auto at = [](double degrees, double r) {
        const double a = degrees * M_PI / 180.0;
        return Vec3(r * std::cos(a), r * std::sin(a), 0.3 * r * std::cos(a));
    };
    const std::vector<Vec3> points{Vec3::Zero(),   at(0.0, 1.0),   at(45.0, 1.3),  at(80.0, 1.2),
                                   at(150.0, 1.0), at(235.0, 2.5), at(250.0, 2.6), at(270.0, 1.0)};
    mesh::TopologyInput tags;
    tags.corners.push_back({0, mesh::infinite_sharpness});
    return test::make_cage(points, {{0, 1, 2, 3}, {0, 3, 4, 5}, {0, 5, 6, 7}}, std::move(tags));
}

}  // namespace

TEST_CASE("uneven concave corners fold until they are settled", "[subd]") {
    mesh::Cage cage = uneven_sector();
    const Vec3 up = Vec3(-0.3, 0.0, 1.0).normalized();
    CHECK(least_cosine(cage, 3, up) < 0.0);
    std::vector<std::uint8_t> held(8, 0);
    for (const std::size_t v : {0, 1, 7}) held[v] = 7;
    subd::CornerSectors corners(*cage.topology, cage.points, held);
    const geom::Points before = cage.points;
    corners.settle(cage.points);
    CHECK(least_cosine(cage, 3, up) > 0.999999);
    for (const int v : {0, 1, 7}) CHECK(cage.points.row(v) == before.row(v));
    const geom::Points settled = cage.points;
    corners.settle(cage.points);
    CHECK((cage.points - settled).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("corners are settled by what is free where an inner edge ends on a feature", "[subd]") {
    const mesh::Cage cage = uneven_sector();
    const Vec3 up = Vec3(-0.3, 0.0, 1.0).normalized();
    const auto settled = [&](std::initializer_list<int> held_vertices) {
        std::vector<std::uint8_t> held(8, 0);
        for (const int v : held_vertices) held[std::size_t(v)] = 7;
        mesh::Cage result = cage;
        subd::CornerSectors(*cage.topology, cage.points, held).settle(result.points);
        for (const int v : held_vertices) CHECK(result.points.row(v) == cage.points.row(v));
        return result;
    };
    CHECK(least_cosine(settled({0, 1, 7, 3}), 3, up) > 0.999999);
    // The edge at 235 degrees is what folds the sector, beyond what an even one at 90 would mend.
    CHECK(settled({0, 1, 7, 5}).points == cage.points);
    CHECK(settled({0, 1, 7, 3, 5}).points == cage.points);
}

TEST_CASE("settled corners stay so under the displacements that are left", "[subd]") {
    mesh::Cage cage = uneven_sector();
    std::vector<std::uint8_t> held(8, 0);
    for (const std::size_t v : {0, 1, 7}) held[v] = 7;
    subd::CornerSectors corners(*cage.topology, cage.points, held);
    corners.settle(cage.points);
    geom::Points x = geom::Points::Random(8, 3), y = geom::Points::Random(8, 3);
    for (const int v : {0, 1, 7}) x.row(v).setZero();
    geom::Points px = x, ty = y;
    corners.project(px);
    corners.project_transposed(ty);
    CHECK((px - x).norm() > 0.1);
    CHECK(px.cwiseProduct(y).sum() == Approx(x.cwiseProduct(ty).sum()));
    geom::Points ppx = px;
    corners.project(ppx);
    CHECK((ppx - px).norm() < 1e-12);
}

TEST_CASE("sectors with an angle have one tangent plane, of any number of faces", "[subd]") {
    for (const int faces : {1, 2, 3, 4, 5}) {
        for (const double degrees : {60.0, 120.0, 200.0, 270.0}) {
            CAPTURE(faces, degrees);
            const mesh::Cage cage = subd::control_normals(open_fan(faces, degrees, 0.2, faces > 1));
            const subd::LimitEvaluator evaluator(cage.topology);
            const subd::LimitPoint first = evaluator.evaluate(cage.points, {FaceId{0}, 0, 0});
            CHECK(first.smoothness != subd::Smoothness::Position);
            for (int f = 0; f < faces; ++f) {
                const subd::LimitPoint p = evaluator.evaluate(cage.points, {FaceId{f}, 0, 0});
                CHECK((p.normal - first.normal).norm() < 1e-9);
                // In concave corners rounding brings back what was taken out, far down.
                const double away = degrees > 180.0 ? 1e-20 : 1e-75;
                const subd::LimitPoint near =
                    evaluator.evaluate(cage.points, {FaceId{f}, away, 0.7 * away}, 1);
                // As (0.4866 / 0.5)^250 at worst.
                CHECK((near.normal - first.normal).norm() < 2e-3);
            }
        }
    }
}

TEST_CASE("prescribed normals are the surface's", "[subd]") {
    const Vec3 normal = Vec3(0.2, -0.3, 1.0).normalized();
    for (const int faces : {2, 3, 4}) {
        for (const double degrees : {90.0, 270.0}) {
            CAPTURE(faces, degrees);
            const mesh::Cage before = open_fan(faces, degrees, 0.2, true, normal);
            const mesh::Cage cage = subd::control_normals(before);
            const subd::LimitEvaluator evaluator(cage.topology);
            const subd::LimitPoint p = evaluator.evaluate(cage.points, {FaceId{0}, 0, 0});
            CHECK((p.normal - normal).norm() < 1e-9);
            CHECK((p.position - before.points.row(0).transpose()).norm() < 1e-15);
            // Refining keeps what was reached, and so does doing it again.
            const mesh::Cage again = subd::control_normals(subd::refine(cage, 1));
            CHECK((again.points - subd::refine(cage, 1).points).cwiseAbs().maxCoeff() < 1e-9);
        }
    }
    // Smooth vertices too.
    mesh::Cage cage = test::cube(2.0);
    mesh::TopologyInput tags;
    tags.sectors.push_back({7, 1, 0.0, {0, 0, 1}});
    cage = subd::control_normals(test::cube(2.0, tags));
    const subd::LimitEvaluator evaluator(cage.topology);
    CHECK((evaluator.evaluate(cage.points, {FaceId{1}, 1, 1}).normal - Vec3(0, 0, 1)).norm() <
          1e-9);
}

TEST_CASE("sector tags are read, checked and written", "[subd][errors]") {
    const std::string corner =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt corner 1/1/0 0 10\n";
    const auto read = [&](const std::string& tag) {
        std::istringstream text(corner + tag);
        return mesh::read_obj(text, "x.obj").cage;
    };
    const mesh::Cage cage = read("#patchwright sector 0 0 270 0 0 1\n");
    REQUIRE(cage.topology->sectors().size() == 1);
    CHECK(cage.topology->sectors()[0].angle == Approx(1.5 * M_PI));
    CHECK(mesh::obj_text(cage).find("#patchwright sector 0 0 270 0 0 1") != std::string::npos);
    CHECK_THROWS_AS(read("#patchwright sector 0 0\n"), base::InputError);
    CHECK_THROWS_AS(read("#patchwright sector 0 1 270\n"), base::InputError);
    CHECK_THROWS_AS(read("#patchwright sector 9 0 270\n"), base::InputError);
    CHECK_THROWS_AS(read("#patchwright sector 0 0 360\n"), base::InputError);
    std::istringstream cube(mesh::obj_text(test::cube(1.0)) + "#patchwright sector 0 0 90\n");
    CHECK_THROWS_WITH(mesh::read_obj(cube, "x.obj"),
                      Catch::Contains("its angle needs two infinitely sharp edges"));
}
