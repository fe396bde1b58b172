// Strips between features that are nearer to each other than a width.
#include "cage/blocks/close_strips.h"

#include "field_shape.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace patchwright {
namespace {

using geom::Vec3;

cage::Poll poll;  // never stops

struct Count {
    int vertices = 0, sides = 0, triangles = 0, feature_sides = 0;
    bool closed = true;  ///< every side has two triangles

    explicit Count(const geom::EditableMesh& mesh) {
        for (int v = 0; v < mesh.vertex_count(); ++v) vertices += mesh.vertex_alive(v) ? 1 : 0;
        std::map<std::pair<int, int>, int> triangles_of;
        for (int t = 0; t < mesh.triangle_count(); ++t) {
            if (!mesh.alive(t)) continue;
            ++triangles;
            for (std::size_t k = 0; k < 3; ++k)
                ++triangles_of[std::minmax(mesh.triangle(t)[k], mesh.triangle(t)[(k + 1) % 3])];
        }
        sides = int(triangles_of.size());
        for (const auto& [side, count] : triangles_of) {
            closed = closed && count == 2;
            feature_sides += mesh.is_feature(side.first, side.second) ? 1 : 0;
        }
    }
    [[nodiscard]] int euler() const { return vertices - sides + triangles; }
};

/// Largest distance of a mesh's vertices from a surface.
double farthest(const geom::EditableMesh& mesh, const geom::ModelSurface& surface) {
    double most = 0.0;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertex_alive(v)) most = std::max(most, surface.foot_point(mesh.point(v)).distance);
    return most;
}

/// A wedge 10 long, 4 thick in front, with a blunt edge at x = 10, and 6 wide.
geom::TriangleMesh wedge(double edge) {
    return test::prism(
        {{{0, -2}, {10, -0.5 * edge}, {10, 0.5 * edge}, {0, 2}}, {{0, 1, 2}, {0, 2, 3}}}, 6.0);
}

TEST_CASE("a blunt edge narrower than the width becomes one line", "[cage][oracle]") {
    constexpr double edge = 0.01;
    const geom::MeshReference reference(wedge(edge));
    geom::EditableMesh mesh(reference.surface_mesh(0.0));
    CHECK(cage::close_strips(mesh, reference, 2.0 * edge, poll) == 1);
    // A prism over a triangle.
    const Count count(mesh);
    CHECK(count.closed);
    CHECK(count.vertices == 6);
    CHECK(count.triangles == 8);
    CHECK(count.feature_sides == 9);
    // The line is one of both edges.
    std::set<double> sides;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertex_alive(v) && mesh.point(v).x() > 9.0) sides.insert(mesh.point(v).y());
    CHECK(sides.size() == 1);
    CHECK(std::abs(*sides.begin()) == Approx(0.5 * edge));
}

TEST_CASE("an edge wider than the width stays", "[cage]") {
    constexpr double edge = 0.01;
    const geom::MeshReference reference(wedge(edge));
    geom::EditableMesh mesh(reference.surface_mesh(0.0));
    const Count before(mesh);
    CHECK(cage::close_strips(mesh, reference, 0.9 * edge, poll) == 0);
    const Count after(mesh);
    CHECK(after.vertices == before.vertices);
    CHECK(after.triangles == before.triangles);
    CHECK(after.feature_sides == before.feature_sides);
}

TEST_CASE("thin plates and bars keep their sides", "[cage]") {
    for (const double other : {6.0, 0.01}) {
        const geom::MeshReference reference(
            test::prism({{{0, 0}, {10, 0}, {10, 0.01}, {0, 0.01}}, {{0, 1, 2}, {0, 2, 3}}}, other));
        geom::EditableMesh mesh(reference.surface_mesh(0.0));
        CHECK(cage::close_strips(mesh, reference, 0.02, poll) == 0);
        CHECK(Count(mesh).vertices == 8);
    }
}

TEST_CASE("vertices of both sides of a strip are on the line", "[cage][oracle]") {
    // The upper edge is parted at one place, the lower one at two, all farther from each other than
    // the width: the line has a vertex for each, and is one of both edges all along.
    constexpr double edge = 0.01, high = 6.0;
    geom::TriangleMesh shape = wedge(edge);
    const auto add = [&](double y, double z) {
        shape.points.conservativeResize(shape.points.rows() + 1, 3);
        shape.points.row(shape.points.rows() - 1) << 10.0, y, z;
        return int(shape.points.rows()) - 1;
    };
    const auto part = [&](int a, int b, int middle) {
        const std::size_t count = shape.triangles.size();
        for (std::size_t t = 0; t < count; ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                auto& c = shape.triangles[t];
                const int from = c[k], to = c[(k + 1) % 3], other = c[(k + 2) % 3];
                if (std::minmax(from, to) != std::minmax(a, b)) continue;
                c = {from, middle, other};
                shape.triangles.push_back({middle, to, other});
                shape.part.push_back(-1);
                break;
            }
    };
    // Points 1 and 2 are at z = 0, 5 and 6 above them.
    const int low = add(-0.5 * edge, 1.0), upper = add(0.5 * edge, 3.0),
              low_next = add(-0.5 * edge, 5.0);
    part(1, 5, low);
    part(low, 5, low_next);
    part(2, 6, upper);
    const geom::MeshReference reference(std::move(shape));
    geom::EditableMesh mesh(reference.surface_mesh(0.0));
    REQUIRE(cage::close_strips(mesh, reference, 2.0 * edge, poll) == 1);
    const Count count(mesh);
    CHECK(count.closed);
    CHECK(count.euler() == 2);
    std::vector<double> along;
    std::set<double> across;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (!mesh.vertex_alive(v) || mesh.point(v).x() < 9.0) continue;
        along.push_back(mesh.point(v).z());
        across.insert(mesh.point(v).y());
    }
    CHECK(across.size() == 1);
    std::sort(along.begin(), along.end());
    REQUIRE(along.size() == 5);
    for (std::size_t k = 0; k < 5; ++k)
        CHECK(along[k] == Approx(std::vector{0.0, 1.0, 3.0, 5.0, high}[k]).margin(1e-9));
    CHECK(farthest(mesh, reference) < 1e-9);
}

/// Half of an ellipsoid with half axes 10, 2 and 0.4, y > 0: the side y = 0 is an ellipse, which
/// one sharp curve runs around.
geom::TriangleMesh half_ellipsoid() {
    constexpr int along = 200, around = 32;
    geom::TriangleMesh mesh;
    mesh.points.resize((along - 1) * (around + 1) + 2, 3);
    const auto number = [](int i, int j) {
        return i == 0 ? 0 : i == along ? 1 : 2 + (i - 1) * (around + 1) + j;
    };
    for (int i = 0; i <= along; ++i)
        for (int j = 0; j <= around; ++j) {
            const double phi = M_PI * i / along, theta = M_PI * j / around;
            mesh.points.row(number(i, j)) << 10.0 * std::cos(phi),
                j == 0 || j == around ? 0.0 : 2.0 * std::sin(phi) * std::sin(theta),
                0.4 * std::sin(phi) * std::cos(theta);
        }
    const auto add = [&](int a, int b, int c) {
        if (a != b && b != c && c != a) mesh.triangles.push_back({a, b, c});
    };
    const auto add_quad = [&](int i, int j, int next) {
        add(number(i, j), number(i, next), number(i + 1, next));
        add(number(i, j), number(i + 1, next), number(i + 1, j));
    };
    for (int i = 0; i < along; ++i) {
        for (int j = 0; j < around; ++j) add_quad(i, j, j + 1);
        add_quad(i, around, 0);
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

TEST_CASE("a line ends where a feature turns back beside itself", "[cage][oracle]") {
    constexpr double widest = 0.8;
    const geom::MeshReference reference(half_ellipsoid());
    REQUIRE(reference.features().curves.size() == 1);
    REQUIRE(reference.features().corners.empty());
    geom::EditableMesh mesh(reference.surface_mesh(0.0));
    SECTION("narrower than the width") {
        REQUIRE(cage::close_strips(mesh, reference, 1.1 * widest, poll) == 1);
        const Count count(mesh);
        CHECK(count.closed);
        CHECK(count.euler() == 2);
        std::vector<int> ends;
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            if (!mesh.vertex_alive(v)) continue;
            const auto next = mesh.feature_neighbours(v);
            CHECK(next.size() <= 2);
            if (next.size() == 1) ends.push_back(v);
        }
        REQUIRE(ends.size() == 2);
        // From tip to tip, which keep to within the width.
        CHECK((mesh.point(ends[0]) - mesh.point(ends[1])).norm() > 20.0 - 2.2 * widest);
        CHECK(farthest(mesh, reference) < 1e-3);
    }
    SECTION("wider") {
        const Count before(mesh);
        CHECK(cage::close_strips(mesh, reference, 0.5 * widest, poll) == 0);
        const Count after(mesh);
        CHECK(after.closed);
        CHECK(after.euler() == before.euler());
    }
}

}  // namespace
}  // namespace patchwright
