#include "support/triangle_shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/geom/mesh_figures.h>

#include <catch2/catch.hpp>

#include <limits>

namespace patchwright::geom {
namespace {

using Catch::Contains;
using test::loose;
using test::triangle_box;

void append(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& shift, bool turned = false) {
    const int base = int(mesh.points.rows());
    mesh.points.conservativeResize(base + other.points.rows(), 3);
    mesh.points.bottomRows(other.points.rows()) = other.points.rowwise() + shift.transpose();
    for (auto t : other.triangles) {
        if (turned) std::swap(t[1], t[2]);
        mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
        mesh.part.push_back(-1);
    }
}

TEST_CASE("loose triangles become one body that faces outward", "[geom][mesh]") {
    TriangleMesh mesh = loose(triangle_box(2, 3, 4));
    // What single precision makes of equal numbers elsewhere; and a third of them turned.
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) mesh.points(i, 0) *= 1.0 + (i % 2) * 1e-7;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    const MeshRepair repair = make_sound(mesh, "box");
    CHECK(mesh.points.rows() == 8);
    CHECK(repair.welded == 36 - 8);
    CHECK(repair.turned == 4);
    CHECK(repair.bodies == 1);
    CHECK(repair.closed_bodies == 1);
    CHECK(repair.free_sides == 0);
    CHECK(measure_mesh(mesh, true).volume == Approx(24.0));
}

TEST_CASE("a body that is inside out as a whole is turned", "[geom][mesh]") {
    TriangleMesh mesh;
    append(mesh, triangle_box(1, 1, 1), Vec3::Zero(), true);
    CHECK(make_sound(mesh, "box").turned == 12);
    CHECK(measure_mesh(mesh, true).volume == Approx(1.0));
}

TEST_CASE("hollows face inward whichever way they came", "[geom][mesh]") {
    for (const bool turned : {false, true}) {
        TriangleMesh mesh = triangle_box(10, 10, 10);
        append(mesh, triangle_box(2, 2, 2), {4, 4, 4}, turned);
        append(mesh, triangle_box(1, 1, 1), {20, 0, 0});
        const MeshRepair repair = make_sound(mesh, "box");
        CHECK(repair.closed_bodies == 3);
        CHECK(repair.hollows == 1);
        CHECK(measure_mesh(mesh, true).volume == Approx(1000.0 - 8.0 + 1.0));
    }
}

TEST_CASE("bodies that touch in a point part there", "[geom][mesh]") {
    TriangleMesh mesh = triangle_box(1, 1, 1);
    append(mesh, triangle_box(1, 1, 1), {1, 1, 1});
    const MeshRepair repair = make_sound(mesh, "two");
    CHECK(repair.bodies == 2);
    CHECK(mesh.points.rows() == 16);
}

TEST_CASE("triangles without three points and copies go", "[geom][mesh]") {
    TriangleMesh mesh = triangle_box(1, 1, 1);
    mesh.triangles.push_back({0, 0, 1});
    mesh.triangles.push_back(mesh.triangles[3]);
    const MeshRepair repair = make_sound(mesh, "box");
    CHECK(repair.degenerate == 1);
    CHECK(repair.duplicates == 1);
    CHECK(mesh.triangles.size() == 12);
}

TEST_CASE("what is no surface is refused with its place", "[geom][mesh]") {
    TriangleMesh crowded = triangle_box(1, 1, 1);
    crowded.triangles.push_back({0, 1, 6});
    CHECK_THROWS_WITH(make_sound(crowded, "a.stl"),
                      Contains("a.stl: 3 triangles meet at the side from (0, 0, 0) to (1, 0, 0)"));

    TriangleMesh broken = triangle_box(1, 1, 1);
    broken.points(7, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(make_sound(broken, "a.stl"),
                      Contains("a.stl: triangle 3 has a point that is not finite"));

    TriangleMesh flat = triangle_box(1, 1, 1);
    flat.points.setZero();
    CHECK_THROWS_WITH(make_sound(flat, "a.stl"),
                      Contains("none of its 12 triangles has three different points"));

    TriangleMesh empty;
    CHECK_THROWS_WITH(make_sound(empty, "a.stl"), Contains("holds no triangles"));

    // Five points, five triangles: the least Moebius strip.
    TriangleMesh strip;
    strip.points.resize(5, 3);
    for (int i = 0; i < 5; ++i)
        strip.points.row(i) << std::cos(1.2566 * i), std::sin(1.2566 * i), 0.1 * i;
    for (int i = 0; i < 5; ++i) strip.triangles.push_back({i, (i + 1) % 5, (i + 2) % 5});
    CHECK_THROWS_WITH(make_sound(strip, "a.stl"), Contains("Moebius"));
}

TEST_CASE("measures of a box are those of the closed form", "[geom][mesh][oracle]") {
    const MeshFigures solid = measure_mesh(triangle_box(2, 3, 4), true);
    CHECK(solid.sides == 18);
    CHECK(solid.free_sides == 0);
    CHECK(solid.area == Approx(52.0));
    CHECK(solid.volume == Approx(24.0));
    CHECK(solid.centre.isApprox(Vec3(1, 1.5, 2), 1e-12));
    CHECK(solid.moments[0] == Approx(24.0 * (4 + 9) / 12.0));
    CHECK(solid.moments[2] == Approx(24.0 * (9 + 16) / 12.0));
    CHECK(solid.shortest_side == Approx(2.0));
    CHECK(solid.smallest_area == Approx(3.0));
    // A cube's surface: six plates of 1 x 1, two at a distance of half from the axis' plane.
    const MeshFigures shell = measure_mesh(triangle_box(1, 1, 1), false);
    CHECK(shell.moments[0] == Approx(2.0 * (1.0 / 6.0) + 4.0 * (1.0 / 12.0 + 0.25)));
}

}  // namespace
}  // namespace patchwright::geom
