// Points of quads that fold or are out of step, moved within a model.
#include "cage/blocks/shape_quads.h"

#include "folded_corners.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

namespace patchwright {
namespace {

using geom::Vec3;

cage::Poll poll;  // never stops

/// Quads of n by n on the side z = size of a box from the origin; points of its border stay.
struct Sheet {
    int n;
    std::vector<Vec3> points, normals;
    std::vector<std::vector<int>> faces;
    std::vector<cage::Freedom> freedom;

    Sheet(int count, double size) : n(count) {
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                points.emplace_back(i * size / n, j * size / n, size);
                freedom.push_back({i > 0 && i < n && j > 0 && j < n, -1});
            }
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const int k = j * (n + 1) + i;
                faces.push_back({k, k + 1, k + n + 2, k + n + 1});
            }
        normals.assign(faces.size(), Vec3::UnitZ());
    }

    [[nodiscard]] int folded() const { return test::folded_corners(points, faces); }
};

TEST_CASE("a folded sheet is opened to even squares", "[cage][oracle]") {
    constexpr double size = 8.0;
    const geom::MeshReference box(test::triangle_box(size, size, size));
    Sheet sheet(8, size);
    const std::vector<Vec3> even = sheet.points;
    // Up to 1.5 edges aside, the same in every run.
    unsigned state = 1;
    const auto aside = [&state] {
        state = state * 1664525U + 1013904223U;
        return 3.0 * (double(state >> 8U) / double(1U << 24U) - 0.5);
    };
    for (std::size_t v = 0; v < sheet.points.size(); ++v)
        if (sheet.freedom[v].free) sheet.points[v] += Vec3(aside(), aside(), 0.0);
    REQUIRE(sheet.folded() > 20);
    cage::shape_quads({sheet.faces, sheet.freedom, {}, sheet.normals}, sheet.points, box, poll);
    CHECK(sheet.folded() == 0);
    // Even squares have the least distortion; points rest at steps of 1e-3 of half an edge.
    double farthest = 0.0;
    for (std::size_t v = 0; v < sheet.points.size(); ++v)
        farthest = std::max(farthest, (sheet.points[v] - even[v]).norm());
    CHECK(farthest < 0.05);
}

TEST_CASE("points of a narrow strip get into step along its feature", "[cage][oracle]") {
    // A strip 0.01 wide between the edge x = 0, z = 8 of a box and fixed points on its top.
    constexpr double size = 8.0, width = 0.01;
    constexpr int n = 8;
    const geom::MeshReference box(test::triangle_box(size, size, size));
    const int edge = box.feature_point(Vec3(0, 4, size), geom::FeatureKind::Sharp)->feature;
    std::vector<Vec3> points;
    std::vector<cage::Freedom> freedom;
    for (int j = 0; j <= n; ++j) {
        const bool end = j == 0 || j == n;
        points.emplace_back(0.0, end ? j : j + 0.7, size);
        freedom.push_back({false, end ? -1 : edge});
        points.emplace_back(width, j, size);
        freedom.push_back({false, -1});
    }
    points[2 * (n - 1)].y() = n - 0.1;
    std::vector<std::vector<int>> faces;
    for (int j = 0; j < n; ++j) faces.push_back({2 * j, 2 * j + 1, 2 * j + 3, 2 * j + 2});
    const std::vector<Vec3> normals(faces.size(), Vec3::UnitZ());
    cage::shape_quads({faces, freedom, {}, normals}, points, box, poll);
    for (int j = 0; j <= n; ++j) {
        CHECK(points[std::size_t(2 * j)].y() == Approx(j).margin(width));
        CHECK(std::hypot(points[std::size_t(2 * j)].x(), points[std::size_t(2 * j)].z() - size) <
              1e-9);
    }
}

}  // namespace
}  // namespace patchwright
