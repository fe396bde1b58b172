// Quads at corners where features leave more than 216 degrees to three or four of them.
#include "cage/blocks/corner_rings.h"

#include "folded_corners.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace patchwright {
namespace {

using geom::Vec3;

cage::Poll poll;  // never stops

constexpr int n = 16, middle = n / 2;

/// Unit squares of the side z = n of a box from the origin; points of its border stay. A notch goes
/// from the middle along x: `slope` to either side of the line, or none, where the line is a
/// crease.
struct Notched {
    std::vector<Vec3> points, normals;
    std::vector<std::vector<int>> faces;
    std::vector<cage::Freedom> freedom;
    std::vector<std::pair<int, int>> creases;

    explicit Notched(double slope) {
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                points.emplace_back(i, j, n);
                const bool on_line = j == middle && i >= middle;
                freedom.push_back({i > 0 && i < n && j > 0 && j < n && !on_line, -1});
            }
        for (int i = middle + 1; i <= n; ++i) {
            points[std::size_t(at(i, middle))].y() += slope * (i - middle);
            points.emplace_back(i, middle - slope * (i - middle), n);  // of quads below the notch
            freedom.push_back({false, -1});
            if (slope == 0.0) creases.emplace_back(at(i - 1, middle), at(i, middle));
        }
        const auto below = [&](int i) {
            return slope > 0.0 && i > middle ? (n + 1) * (n + 1) + i - middle - 1 : at(i, middle);
        };
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const bool ends_there = j == middle - 1;
                faces.push_back({at(i, j), at(i + 1, j),
                                 ends_there ? below(i + 1) : at(i + 1, j + 1),
                                 ends_there ? below(i) : at(i, j + 1)});
            }
        normals.assign(faces.size(), Vec3::UnitZ());
    }

    static int at(int i, int j) { return j * (n + 1) + i; }
    Vec3& point(int i, int j) { return points[std::size_t(at(i, j))]; }
    [[nodiscard]] cage::QuadsOnModel quads() const { return {faces, freedom, creases, normals}; }

    [[nodiscard]] int folded() const { return test::folded_corners(points, faces); }
};

const geom::MeshReference& box() {
    static const geom::MeshReference reference(test::triangle_box(n, n, n));
    return reference;
}

/// As metrics with long edges in one direction leave them: 65, 39, 140 and 104 degrees or so.
void skew(Notched& sheet) {
    sheet.point(middle, middle + 1) += Vec3(0.7, 0.6, 0.0);
    sheet.point(middle - 1, middle) += Vec3(0.8, 1.2, 0.0);
    sheet.point(middle, middle - 1) += Vec3(-0.4, 0.0, 0.0);
}

TEST_CASE("four quads around a narrow notch get even angles and like edges", "[cage][oracle]") {
    constexpr double slope = 0.1;
    Notched sheet(slope);
    const std::vector<Vec3> given = sheet.points;
    skew(sheet);
    cage::even_corner_rings(sheet.quads(), sheet.points, box(), poll);
    const Vec3 corner = sheet.point(middle, middle);
    const double half_notch = std::atan(slope), edge = std::hypot(1.0, slope);
    const double step = (2.0 * std::numbers::pi - 2.0 * half_notch) / 4.0;
    const std::vector<std::pair<int, int>> ends{{0, 1}, {-1, 0}, {0, -1}};
    for (std::size_t k = 0; k < ends.size(); ++k) {
        const double angle = half_notch + double(k + 1) * step;
        // No edge was shorter than those of the notch but the third, which is 1.077 long.
        const Vec3 expected = corner + edge * Vec3(std::cos(angle), std::sin(angle), 0.0);
        const Vec3 found = sheet.point(middle + ends[k].first, middle + ends[k].second);
        CHECK((found - expected).norm() < 1e-9);
    }
    CHECK(sheet.folded() == 0);
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            if (std::abs(i - middle) > 5 || std::abs(j - middle) > 5)
                CHECK(sheet.point(i, j) == given[std::size_t(Notched::at(i, j))]);
}

TEST_CASE("edges at a wide corner are not made longer", "[cage]") {
    Notched sheet(0.1);
    sheet.point(middle - 1, middle) = Vec3(middle - 0.3, middle, n);
    cage::even_corner_rings(sheet.quads(), sheet.points, box(), poll);
    CHECK((sheet.point(middle - 1, middle) - Vec3(middle - 0.3, middle, n)).norm() < 1e-9);
}

TEST_CASE("edges at a wide corner become shorter where another feature is near", "[cage]") {
    Notched sheet(0.1);
    const Vec3 corner = sheet.point(middle, middle);
    const double distance = 0.6;  // of a point that stays: the next one on the edge's line
    sheet.point(middle - 2, middle) = corner - Vec3(distance, 0.0, 0.0);
    sheet.freedom[std::size_t(Notched::at(middle - 2, middle))] = {.free = false};
    REQUIRE(sheet.folded() > 0);
    cage::even_corner_rings(sheet.quads(), sheet.points, box(), poll);
    const Vec3 edge = sheet.point(middle - 1, middle) - corner;
    CHECK(edge.x() < 0.0);
    CHECK(edge.x() > -distance);
    CHECK(std::abs(edge.y()) < 1e-9);  // half of the angle that the notch leaves is 180 degrees
    CHECK(sheet.folded() == 0);
}

TEST_CASE("quads stay around the end of a crease, and at corners of 200 degrees", "[cage]") {
    const double slope = GENERATE(0.0, std::tan(80.0 * std::numbers::pi / 180.0));
    Notched sheet(slope);
    skew(sheet);
    const std::vector<Vec3> before = sheet.points;
    cage::even_corner_rings(sheet.quads(), sheet.points, box(), poll);
    CHECK(sheet.points == before);
}

}  // namespace
}  // namespace patchwright
