// Quads from triangles: strips whose best pairing is known.
#include "cage/remesh/merge_triangles.h"
#include "cage/remesh/quad_shape.h"

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
    const geom::EditableMesh mesh(surface);
    cage::Polygons polygons = squares_between_triangles(bottom, top);
    REQUIRE(triangles_of(polygons) == 2);
    cage::Poll poll;
    cage::merge_triangles(polygons, mesh, poll);
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
    const geom::EditableMesh mesh(surface);
    cage::Polygons polygons = squares_between_triangles(bottom, top);
    cage::Poll poll;
    cage::merge_triangles(polygons, mesh, poll);
    CHECK(triangles_of(polygons) == 2);
    CHECK(polygons.corners.size() == 6);
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
