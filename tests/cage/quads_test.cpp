// Quads from triangles: strips and plates whose best quads are known.
#include "cage/remesh/border_rows.h"
#include "cage/remesh/even_regions.h"
#include "cage/remesh/merge_triangles.h"
#include "cage/remesh/quad_shape.h"
#include "cage/remesh/tidy_quads.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>

namespace patchwright {
namespace {

using geom::Vec3;

/// Points (i, y) on a convex parabola, and (i + 1, 1) from number `bottom` on, i from 0.
geom::SurfaceMesh trapezoid(int bottom, int top) {
    geom::SurfaceMesh mesh;
    mesh.points.resize(bottom + top, 3);
    for (int i = 0; i < bottom; ++i) mesh.points.row(i) << i, 0.15 * i * (i - bottom + 1), 0;
    for (int i = 0; i < top; ++i) mesh.points.row(bottom + i) << i + 1, 1, 0;
    mesh.triangles.push_back({0, 1, bottom});
    for (int i = 0; i + 1 < top; ++i) {
        mesh.triangles.push_back({i + 1, i + 2, bottom + i});
        mesh.triangles.push_back({i + 2, bottom + i + 1, bottom + i});
    }
    mesh.triangles.push_back({bottom - 2, bottom - 1, bottom + top - 1});
    mesh.faces.assign(mesh.triangles.size(), 0);
    mesh.corners.assign(std::size_t(bottom + top), -1);
    return mesh;
}

/// Squares between a triangle at either end.
cage::Polygons squares_between_triangles(int bottom, int top) {
    cage::Polygons polygons;
    polygons.corners.push_back({0, 1, bottom});
    for (int i = 0; i + 1 < top; ++i)
        polygons.corners.push_back({i + 1, i + 2, bottom + i + 1, bottom + i});
    polygons.corners.push_back({bottom - 2, bottom - 1, bottom + top - 1});
    polygons.faces.assign(polygons.corners.size(), 0);
    return polygons;
}

int triangles_of(const cage::Polygons& polygons) {
    int count = 0;
    for (const auto& c : polygons.corners) count += c.size() == 3 ? 1 : 0;
    return count;
}

TEST_CASE("two triangles merge through the quads between them", "[layout][mesh]") {
    constexpr int bottom = 7, top = 5;
    const geom::SurfaceMesh surface = trapezoid(bottom, top);
    geom::EditableMesh mesh(surface);
    cage::PolygonMesh edited(squares_between_triangles(bottom, top), mesh);
    REQUIRE(triangles_of(edited.polygons()) == 2);
    cage::Poll poll;
    CHECK(cage::merge_triangles(edited, poll));
    const cage::Polygons polygons = edited.polygons();
    CHECK(triangles_of(polygons) == 0);
    REQUIRE(polygons.corners.size() == 5);
    REQUIRE(polygons.faces.size() == 5);
    double area = 0.0, surface_area = 0.0;
    for (int t = 0; t < mesh.triangle_count(); ++t) surface_area += 0.5 * mesh.area_vector(t).z();
    for (const auto& c : polygons.corners) {
        REQUIRE(c.size() == 4);
        const auto p = [&](std::size_t k) { return mesh.point(c[k]); };
        CHECK(cage::quad_quality({p(0), p(1), p(2), p(3)}) > 0.0);
        area += 0.5 * (p(2) - p(0)).cross(p(3) - p(1)).z();
    }
    CHECK(area == Approx(surface_area));
}

TEST_CASE("triangles do not merge across features", "[layout][mesh]") {
    constexpr int bottom = 7, top = 5;
    geom::SurfaceMesh surface = trapezoid(bottom, top);
    surface.features.push_back({3, bottom + 2, 0});
    geom::EditableMesh mesh(surface);
    cage::PolygonMesh edited(squares_between_triangles(bottom, top), mesh);
    cage::Poll poll;
    CHECK_FALSE(cage::merge_triangles(edited, poll));
    const cage::Polygons polygons = edited.polygons();
    CHECK(triangles_of(polygons) == 2);
    CHECK(polygons.corners.size() == 6);
}

/// Squares on both sides of a fold of 90 degrees along x, with a triangle on the far side of the
/// middle one of each.
geom::TriangleMesh folded_plate(int squares) {
    geom::TriangleMesh mesh;
    const int row = squares + 1, tip = 3 * row, middle = squares / 2;
    mesh.points.resize(tip + 2, 3);
    for (int i = 0; i < row; ++i) {
        mesh.points.row(i) << i, 0, 0;
        mesh.points.row(row + i) << i, 1, 0;
        mesh.points.row(2 * row + i) << i, 0, 1;
    }
    mesh.points.row(tip) << middle + 0.5, 1.2, 0;
    mesh.points.row(tip + 1) << middle + 0.5, 0, 1.2;
    for (int i = 0; i < squares; ++i) {
        mesh.triangles.push_back({i, i + 1, row + i + 1});
        mesh.triangles.push_back({i, row + i + 1, row + i});
        mesh.triangles.push_back({i + 1, i, 2 * row + i});
        mesh.triangles.push_back({i + 1, 2 * row + i, 2 * row + i + 1});
    }
    mesh.triangles.push_back({row + middle, row + middle + 1, tip});
    mesh.triangles.push_back({2 * row + middle + 1, 2 * row + middle, tip + 1});
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

TEST_CASE("an edge between two regions is split where both have a triangle", "[layout][mesh]") {
    constexpr int squares = 5, row = squares + 1;
    const geom::MeshReference reference(folded_plate(squares));
    geom::EditableMesh mesh(reference.surface_mesh(1e-3));
    cage::Polygons polygons;
    for (int i = 0; i < squares; ++i) {
        polygons.corners.push_back({i, i + 1, row + i + 1, row + i});
        polygons.corners.push_back({i + 1, i, 2 * row + i, 2 * row + i + 1});
    }
    polygons.corners.push_back({row + 2, row + 3, 3 * row});
    polygons.corners.push_back({2 * row + 3, 2 * row + 2, 3 * row + 1});
    polygons.faces.assign(polygons.corners.size(), 0);
    cage::PolygonMesh edited(polygons, mesh);
    REQUIRE(edited.is_feature(2, 3));
    cage::Poll poll;
    cage::merge_triangles(edited, poll);
    REQUIRE(triangles_of(edited.polygons()) == 2);
    cage::make_regions_even(edited, reference, poll);
    // The middle of the fold's middle edge.
    REQUIRE(mesh.vertex_count() == 3 * row + 3);
    CHECK((mesh.point(3 * row + 2) - Vec3(2.5, 0, 0)).norm() < 1e-9);
    CHECK_FALSE(edited.is_feature(2, 3));
    CHECK(triangles_of(edited.polygons()) == 4);
    cage::merge_triangles(edited, poll);
    CHECK(triangles_of(edited.polygons()) == 0);
    CHECK(edited.polygons().corners.size() == 2 * squares + 2);
}

/// Squares of a plate of n x n, all with diagonals the same way.
geom::SurfaceMesh plate(int n) {
    geom::SurfaceMesh mesh;
    mesh.points.resize((n + 1) * (n + 1), 3);
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) mesh.points.row(j * (n + 1) + i) << i, j, 0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i;
            mesh.triangles.push_back({a, a + 1, a + n + 2});
            mesh.triangles.push_back({a, a + n + 2, a + n + 1});
        }
    mesh.faces.assign(mesh.triangles.size(), 0);
    mesh.corners.assign(std::size_t(mesh.points.rows()), -1);
    return mesh;
}

cage::Polygons squares_of(int n) {
    cage::Polygons polygons;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i;
            polygons.corners.push_back({a, a + 1, a + n + 2, a + n + 1});
        }
    polygons.faces.assign(polygons.corners.size(), 0);
    return polygons;
}

int irregularity(const cage::PolygonMesh& polygons) {
    int sum = 0;
    for (int v = 0; v < polygons.mesh().vertex_count(); ++v)
        if (!polygons.at_vertex(v).empty()) sum += polygons.irregularity(v);
    return sum;
}

TEST_CASE("a turned edge and an opened one are put right", "[layout][mesh]") {
    constexpr int n = 6;
    geom::EditableMesh mesh(plate(n));
    cage::Poll poll;
    {
        cage::PolygonMesh regular(squares_of(n), mesh);
        const int at_border = irregularity(regular);
        CHECK_FALSE(cage::tidy_quads(regular, poll));
        CHECK(irregularity(regular) == at_border);
    }
    // Two squares of the middle with the edge between them turned by one corner.
    cage::Polygons turned = squares_of(n);
    const int a = 2 * (n + 1) + 2, up = n + 1;
    turned.corners[2 * n + 2] = {a, a + 1, a + 2, a + 2 + up};
    turned.corners[2 * n + 3] = {a + 2 + up, a + 1 + up, a + up, a};
    cage::PolygonMesh edited(turned, mesh);
    const cage::PolygonMesh squares(squares_of(n), mesh);
    REQUIRE(irregularity(edited) == irregularity(squares) + 4);
    CHECK(cage::tidy_quads(edited, poll));
    CHECK(irregularity(edited) == irregularity(squares));
    // A vertex of the middle opened to a square: a collapse along its diagonal closes it.
    geom::EditableMesh opened_mesh(plate(n));
    cage::Polygons opened = squares_of(n);
    const int v = 3 * (n + 1) + 3;
    const int made = opened_mesh.add_vertex(Vec3(3, 3.3, 0));
    opened_mesh.move(v, Vec3(3, 2.7, 0));
    for (const int upper : {3 * n + 2, 3 * n + 3})
        std::replace(opened.corners[std::size_t(upper)].begin(),
                     opened.corners[std::size_t(upper)].end(), v, made);
    opened.corners.push_back({v, v + 1, made, v - 1});
    opened.faces.push_back(0);
    cage::PolygonMesh closed(opened, opened_mesh);
    REQUIRE(irregularity(closed) == irregularity(squares) + 4);
    CHECK(cage::tidy_quads(closed, poll));
    CHECK(irregularity(closed) == irregularity(squares));
    CHECK(closed.polygons().corners.size() == std::size_t(n * n));
}

/// A fan of triangles in a circle, whose first `features` sides are feature edges.
struct CircleFan {
    static constexpr int sides = 6;

    explicit CircleFan(int features) {
        surface.points.resize(sides + 1, 3);
        surface.points.row(sides) << 0, 0, 0;
        for (int i = 0; i < sides; ++i) {
            const double angle = 2.0 * M_PI * i / sides;
            surface.points.row(i) << std::cos(angle), std::sin(angle), 0;
            const int next = (i + 1) % sides;
            surface.triangles.push_back({i, next, sides});
            if (i < features) surface.features.push_back({std::min(i, next), std::max(i, next), 0});
            polygons.corners.push_back({i, next, sides});
        }
        surface.faces.assign(surface.triangles.size(), 0);
        surface.corners.assign(sides + 1, -1);
        polygons.faces.assign(polygons.corners.size(), 0);
    }

    geom::SurfaceMesh surface;
    cage::Polygons polygons;
};

TEST_CASE("a fan of triangles in a circle becomes quads inside a row of quads", "[layout][mesh]") {
    const CircleFan fan(CircleFan::sides);
    geom::EditableMesh mesh(fan.surface);
    cage::PolygonMesh edited(fan.polygons, mesh);
    cage::Poll poll;
    // Quads around the middle would leave every other vertex of the circle with one face.
    CHECK_FALSE(cage::merge_triangles(edited, poll));
    CHECK(cage::add_border_rows(edited));
    CHECK(cage::merge_triangles(edited, poll));
    CHECK(triangles_of(edited.polygons()) == 0);
    CHECK(edited.polygons().corners.size() == CircleFan::sides + 3);
    for (int v = 0; v < CircleFan::sides; ++v) CHECK(edited.flaws(v) == 0);
}

TEST_CASE("a region with an open end gets no row of quads along its border", "[layout][mesh]") {
    const CircleFan fan(CircleFan::sides - 2);
    geom::EditableMesh mesh(fan.surface);
    cage::PolygonMesh edited(fan.polygons, mesh);
    CHECK_FALSE(cage::add_border_rows(edited));
    CHECK(edited.polygons().corners == fan.polygons.corners);
}

TEST_CASE("the quality of quads and triangles", "[layout][mesh][oracle]") {
    const Vec3 o(0, 0, 0), x(2, 0, 0), y(0, 1, 0), xy(2, 1, 0);
    CHECK(cage::quad_quality({o, x, xy, y}) == Approx(1.0));
    // A rhombus of 60 degrees: its worst angles are a third of a right one off.
    const Vec3 slant(0.5, std::sqrt(0.75), 0), unit(1, 0, 0);
    CHECK(cage::quad_quality({o, unit, Vec3(unit + slant), slant}) == Approx(2.0 / 3.0));
    CHECK(cage::quad_quality({o, x, Vec3(0.4, 0.2, 0), y}) == 0.0);  // not convex
    CHECK(cage::triangle_quality({o, unit, slant}) == Approx(1.0));
    CHECK(cage::triangle_quality({o, Vec3(1, 0, 0), Vec3(0, 1, 0)}) == Approx(0.75));
}

}  // namespace
}  // namespace patchwright
