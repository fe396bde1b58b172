#include "geom/editable_mesh.h"

#include <catch2/catch.hpp>

#include <set>

namespace patchwright::geom {
namespace {

/// A flat 4 x 4 grid of squares, two triangles each; its border is a feature with corners.
SurfaceMesh flat_grid() {
    constexpr int n = 4;
    SurfaceMesh mesh;
    mesh.points.resize((n + 1) * (n + 1), 3);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) mesh.points.row(i * (n + 1) + j) << i, j, 0.0;
    mesh.corners.assign(std::size_t(mesh.points.rows()), -1);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const int a = i * (n + 1) + j, b = a + n + 1, c = b + 1, d = a + 1;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
            mesh.faces.insert(mesh.faces.end(), {0, 0});
        }
        const int top = n * (n + 1);
        mesh.features.push_back({i, i + 1, 0});
        mesh.features.push_back({top + i, top + i + 1, 1});
        mesh.features.push_back({i * (n + 1), (i + 1) * (n + 1), 2});
        mesh.features.push_back({i * (n + 1) + n, (i + 1) * (n + 1) + n, 3});
    }
    for (const int corner : {0, n, n * (n + 1), n * (n + 2)}) mesh.corners[std::size_t(corner)] = 0;
    return mesh;
}

double area(const EditableMesh& mesh) {
    double sum = 0.0;
    for (int t = 0; t < mesh.triangle_count(); ++t)
        if (mesh.alive(t)) sum += 0.5 * mesh.area_vector(t).z();
    return sum;
}

/// Length of the feature sides, each once.
double feature_length(const EditableMesh& mesh) {
    std::set<std::pair<int, int>> sides;
    double sum = 0.0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        for (int k = 0; k < 3 && mesh.alive(t); ++k) {
            const int a = mesh.triangle(t)[std::size_t(k)];
            const int b = mesh.triangle(t)[std::size_t((k + 1) % 3)];
            if (mesh.curve(t, k) >= 0 && sides.insert(std::minmax(a, b)).second)
                sum += (mesh.point(a) - mesh.point(b)).norm();
        }
    }
    return sum;
}

TEST_CASE("vertices know their features", "[layout]") {
    const EditableMesh mesh(flat_grid());
    CHECK(mesh.kind(12) == VertexKind::Smooth);
    CHECK(mesh.kind(2) == VertexKind::Curve);
    CHECK(mesh.curve_at(2) == 0);
    CHECK(mesh.kind(0) == VertexKind::Fixed);
    CHECK(mesh.is_boundary(2));
    for (const int corner : {0, 4, 20, 24}) CHECK(mesh.is_boundary(corner));
    CHECK_FALSE(mesh.is_boundary(12));
}

TEST_CASE("collapses keep area, features and corners", "[layout]") {
    EditableMesh mesh(flat_grid());
    CHECK_FALSE(mesh.can_collapse(0, 1));    // a corner stays
    CHECK_FALSE(mesh.can_collapse(2, 7));    // a curve's vertex goes along its curve only
    CHECK_FALSE(mesh.can_collapse(12, 24));  // no edge
    REQUIRE(mesh.can_collapse(2, 1));
    REQUIRE(mesh.can_collapse(12, 7));
    REQUIRE(mesh.collapse_is_flat(12, 7, 0.5));
    mesh.collapse(12, 7);
    CHECK_FALSE(mesh.vertex_alive(12));
    CHECK(area(mesh) == Approx(16.0));
    CHECK(feature_length(mesh) == Approx(16.0));
    mesh.collapse(2, 1);
    CHECK(area(mesh) == Approx(16.0));
    CHECK(feature_length(mesh) == Approx(16.0));
    CHECK(mesh.feature_neighbours(1).size() == 2);
}

TEST_CASE("negligible triangles do not hold a collapse", "[layout]") {
    SurfaceMesh folded = flat_grid();
    folded.points.row(12) << 2.0, 2.4, 0.0;
    folded.points.row(7) << 1.0, 2.6, 0.0;
    EditableMesh mesh(folded);
    mesh.move(12, {1.0, 3.3, 0.0});  // beyond its neighbours: two triangles are turned over
    CHECK_FALSE(mesh.collapse_is_flat(12, 7, 0.5));
    CHECK_FALSE(mesh.collapse_is_flat(12, 7, 0.5, 0.5));
    CHECK(mesh.collapse_is_flat(12, 7, 0.5, 10.0));
}

TEST_CASE("splits and flips keep area and features", "[layout]") {
    EditableMesh mesh(flat_grid());
    const int inner = mesh.split(6, 12, {1.5, 1.5, 0.0});
    CHECK(mesh.kind(inner) == VertexKind::Smooth);
    CHECK(mesh.fan(inner).size() == 4);
    const int outer = mesh.split(1, 2, {0.0, 1.5, 0.0});
    CHECK(mesh.kind(outer) == VertexKind::Curve);
    CHECK(mesh.curve_at(outer) == 0);
    CHECK_FALSE(mesh.can_flip(1, outer));  // features stay
    REQUIRE(mesh.can_flip(12, 18));
    mesh.flip(12, 18);
    CHECK(mesh.sides(12, 18).triangle[0] < 0);
    CHECK(mesh.sides(13, 17).triangle[1] >= 0);
    CHECK(area(mesh) == Approx(16.0));
    CHECK(feature_length(mesh) == Approx(16.0));
}

}  // namespace
}  // namespace patchwright::geom
