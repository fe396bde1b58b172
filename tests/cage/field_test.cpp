// Cross fields and their layouts on shapes whose topology is known.
#include "cage/field/field_lines.h"
#include "cage/field/vertex_fan.h"
#include "cage/remesh/remesh.h"
#include "field_shape.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

namespace patchwright {
namespace {

using geom::Vec3;
using test::Field;
using test::Outline;
using test::prism;

cage::Poll poll;  // never stops

constexpr int around = 32;  // sides of circles

geom::TriangleMesh l_block() {
    return prism({{{0, 0}, {20, 0}, {20, 10}, {10, 10}, {10, 20}, {0, 20}},
                  {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}},
                 10.0);
}

/// A square plate with a round hole in its middle.
geom::TriangleMesh plate_with_hole() {
    Outline plate;
    for (int j = 0; j < around; ++j) {
        const double angle = 2.0 * M_PI * j / around;
        plate.points.emplace_back(6.0 * std::cos(angle), 6.0 * std::sin(angle));
    }
    for (const auto& [x, y] : {std::pair{20, 20}, {-20, 20}, {-20, -20}, {20, -20}})
        plate.points.emplace_back(x, y);
    constexpr int quarter = around / 4;
    for (int q = 0; q < 4; ++q) {
        const int corner = around + q, last = around + (q + 3) % 4;
        plate.triangles.push_back({quarter * q, last, corner});
        for (int j = quarter * q; j < quarter * (q + 1); ++j)
            plate.triangles.push_back({j, corner, (j + 1) % around});
    }
    return prism(plate, 10.0);
}

geom::TriangleMesh torus(double large, double small) {
    geom::TriangleMesh mesh;
    mesh.points.resize(around * around, 3);
    const auto number = [](int i, int j) { return i % around * around + j % around; };
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < around; ++j) {
            const double a = 2.0 * M_PI * i / around, b = 2.0 * M_PI * j / around;
            const double r = large + small * std::cos(b);
            mesh.points.row(number(i, j)) << r * std::cos(a), r * std::sin(a), small * std::sin(b);
            mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
            mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
        }
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// A tube along z with a narrow triangle cut out of its side; its tip points up, to height `tip`.
geom::TriangleMesh tube_with_notch(double radius, double tip) {
    // Four columns and rows on either side of the tip; rows are four times as high as columns are
    // wide.
    constexpr int rows = 16, tip_row = 10, tip_column = around / 2, size = 4;
    const double height = tip / tip_row;
    geom::TriangleMesh mesh;
    mesh.points.resize(around * (rows + 1), 3);
    const auto number = [](int column, int row) { return row * around + column % around; };
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i < around; ++i)
            mesh.points.row(number(i, j)) << radius * std::cos(2.0 * M_PI * i / around),
                radius * std::sin(2.0 * M_PI * i / around), height * j;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < around; ++i) {
            const int a = number(i, j), b = number(i + 1, j), c = number(i + 1, j + 1),
                      d = number(i, j + 1);
            // The notch has its sides along diagonals.
            const bool left = i < tip_column;
            const int from_side = (left ? tip_column - 1 - i : i - tip_column) - (tip_row - 1 - j);
            const bool in_rows = j >= tip_row - size && j < tip_row;
            const auto upper = left ? std::array{a, c, d} : std::array{b, c, d};
            const auto lower = left ? std::array{a, b, c} : std::array{a, b, d};
            if (!in_rows || from_side >= 0) mesh.triangles.push_back(upper);
            if (!in_rows || from_side > 0) mesh.triangles.push_back(lower);
        }
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// Two flat pyramids on one square, whose corners are rounded within less than a triangle.
geom::TriangleMesh pillow(double half, double radius, double height) {
    constexpr int steps = 6;
    geom::TriangleMesh mesh;
    constexpr int n = 4 * (steps + 1);
    mesh.points.resize(n + 2, 3);
    for (int q = 0; q < 4; ++q)
        for (int k = 0; k <= steps; ++k) {
            const double angle = 0.5 * M_PI * (q + double(k) / steps);
            const double x = (q == 0 || q == 3 ? 1.0 : -1.0) * (half - radius),
                         y = (q < 2 ? 1.0 : -1.0) * (half - radius);
            mesh.points.row(q * (steps + 1) + k) << x + radius * std::cos(angle),
                y + radius * std::sin(angle), 0.0;
        }
    mesh.points.row(n) << 0, 0, height;
    mesh.points.row(n + 1) << 0, 0, -height;
    for (int i = 0; i < n; ++i) {
        mesh.triangles.push_back({i, (i + 1) % n, n});
        mesh.triangles.push_back({(i + 1) % n, i, n + 1});
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

geom::TriangleMesh turned(geom::TriangleMesh mesh) {
    const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()) *
                                  Eigen::AngleAxisd(1.9, Vec3::UnitZ()))
                                     .toRotationMatrix();
    mesh.points = (mesh.points * turn.transpose()).eval();
    return mesh;
}

TEST_CASE("indices of a cross field sum up to the Euler characteristic", "[field][oracle]") {
    // Of all regions between sharp edges: 6 discs; a sphere; a torus; two discs and a ring; 8
    // discs; 4 discs and 3 rings.
    const std::vector<std::pair<geom::TriangleMesh, int>> shapes{
        {test::triangle_box(10, 20, 30), 6},
        {test::triangle_sphere(10.0, around), 2},
        {torus(20, 6), 0},
        {test::triangle_cylinder(10, 30, around), 2},
        {l_block(), 8},
        {plate_with_hole(), 4}};
    for (const auto& [triangles, euler] : shapes) {
        const Field made(triangles);
        CHECK(made.topology.mismatches.empty());
        CHECK(made.quarters() == 4 * euler);
    }
}

TEST_CASE("crosses lie along sharp edges", "[field][oracle]") {
    const Field made(plate_with_hole());
    int sides = 0;
    for (int t = 0; t < made.mesh.triangle_count(); ++t) {
        if (!made.mesh.alive(t)) continue;
        for (int k = 0; k < 3; ++k) {
            if (made.mesh.curve(t, k) < 0) continue;
            const auto& c = made.mesh.triangle(t);
            const Vec3 side =
                (made.mesh.point(c[std::size_t((k + 1) % 3)]) - made.mesh.point(c[std::size_t(k)]))
                    .normalized();
            const double cosine = side.dot(made.field.direction[std::size_t(t)]);
            CHECK(std::abs(cosine * cosine * (1.0 - cosine * cosine)) < 1e-12);
            ++sides;
        }
    }
    CHECK(sides > 100);
}

TEST_CASE("a torus gets crosses along its circles and no singularity", "[field][oracle]") {
    const Field made(torus(20, 6));
    CHECK(made.topology.singularities.empty());
    double worst = 0.0;
    for (int t = 0; t < made.mesh.triangle_count(); ++t) {
        if (!made.mesh.alive(t)) continue;
        const auto& c = made.mesh.triangle(t);
        const Vec3 middle =
            (made.mesh.point(c[0]) + made.mesh.point(c[1]) + made.mesh.point(c[2])) / 3.0;
        const Vec3 circle = Vec3(-middle.y(), middle.x(), 0.0).normalized();
        const double cosine = std::abs(circle.dot(made.field.direction[std::size_t(t)]));
        worst = std::max(worst, std::min(std::acos(std::min(1.0, cosine)), std::asin(cosine)));
    }
    CHECK(worst < 0.2);
}

TEST_CASE("a turned shape has as many singularities", "[field]") {
    for (const auto& shape : {plate_with_hole(), test::triangle_sphere(10.0, around)})
        CHECK(Field(shape).topology.singularities.size() ==
              Field(turned(shape)).topology.singularities.size());
}

TEST_CASE("where a rim turns sharply no two quads share two edges", "[field]") {
    // Seen from above and from below there is room for one quad at each corner of the square; the
    // rim is smooth there, so that two quads would fold along it.
    const Field made(pillow(10.0, 0.2, 6.0));
    std::map<int, std::vector<int>> quads;
    for (const cage::FieldSector& s : made.topology.sectors) quads[s.vertex].push_back(s.quads);
    int turns = 0;
    for (auto& [v, sectors] : quads) {
        if (sectors.size() != 2 || made.mesh.corner(v) >= 0) continue;
        std::sort(sectors.begin(), sectors.end());
        CHECK(sectors[1] > 1);
        turns += sectors[0] == 1 ? 1 : 0;
    }
    CHECK(turns == 4);
}

TEST_CASE("a field that cannot be one of quads is named", "[field]") {
    // A triangle with three sides on sharp edges has one cross only: three corners are not four.
    const geom::MeshReference reference(prism({{{0, 0}, {10, 0}, {5, 8}}, {{0, 1, 2}}}, 30.0));
    const geom::EditableMesh mesh(reference.surface_mesh(0.0));
    const auto topology = cage::field_topology(mesh, cage::cross_field(mesh, {}, poll));
    CHECK(topology.mismatches.size() == 2);
}

/// What lines and features part a surface into, and the corners that each region has by its
/// sectors: 2 - quads, summed.
std::vector<int> corners_of_regions(const geom::EditableMesh& mesh, const cage::FieldLines& made) {
    std::set<std::pair<int, int>> walls;
    for (const auto& line : made.lines)
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
            REQUIRE(mesh.sides(line[i], line[i + 1]).triangle[0] >= 0);
            walls.insert(std::minmax(line[i], line[i + 1]));
        }
    std::vector<int> region(std::size_t(mesh.triangle_count()), -1), corners;
    for (int seed = 0; seed < mesh.triangle_count(); ++seed) {
        if (!mesh.alive(seed) || region[std::size_t(seed)] >= 0) continue;
        std::vector<int> pending{seed};
        region[std::size_t(seed)] = int(corners.size());
        for (std::size_t i = 0; i < pending.size(); ++i) {
            const auto& c = mesh.triangle(pending[i]);
            for (int k = 0; k < 3; ++k) {
                const int a = c[std::size_t(k)], b = c[std::size_t((k + 1) % 3)];
                if (cage::is_border(mesh, pending[i], k) || walls.contains(std::minmax(a, b)))
                    continue;
                const int next = cage::across(mesh, pending[i], k);
                if (region[std::size_t(next)] >= 0) continue;
                region[std::size_t(next)] = int(corners.size());
                pending.push_back(next);
            }
        }
        corners.push_back(0);
    }
    for (const cage::FieldSector& s : made.sectors) {
        const auto fan = cage::fan_from(mesh, s.vertex, s.next, [](int, int) { return true; });
        corners[std::size_t(region[std::size_t(fan.wedges[0].triangle)])] += 2 - s.quads;
    }
    return corners;
}

TEST_CASE("lines of a field part shapes into the known numbers of four-sided regions",
          "[field][layout][oracle]") {
    // A box has six. From the reflex corners of an L two lines go across: three regions each. Both
    // lids of a cylinder get a square and four around it, its mantle four cuts. A hole in a square
    // has four regions around it, four at the corners and four between them.
    const std::vector<std::pair<geom::TriangleMesh, std::size_t>> shapes{
        {test::triangle_box(10, 20, 30), 6},
        {l_block(), 6 + 2 * 3},
        {test::triangle_cylinder(10, 30, around), 4 + 2 * 5},
        {plate_with_hole(), 4 + 4 + 2 * 12}};
    for (const auto& [triangles, count] : shapes) {
        for (const bool turn : {false, true}) {
            Field made(turn ? turned(triangles) : triangles);
            const auto lines = cage::field_lines(made.mesh, made.field, made.topology, poll);
            const auto corners = corners_of_regions(made.mesh, lines);
            CHECK(corners.size() == count);
            for (const int c : corners) CHECK(c == 4);
        }
    }
}

TEST_CASE("a line around a tube ends where it began", "[field][layout]") {
    // From the tip of the notch lines go up and both ways around; these two are the same.
    constexpr double tip = 80.0;
    Field made(tube_with_notch(10.0, tip));
    const auto lines = cage::field_lines(made.mesh, made.field, made.topology, poll);
    const int closed = int(
        std::count_if(lines.lines.begin(), lines.lines.end(), [&](const std::vector<int>& line) {
            return line.size() > 2 && line.front() == line.back() &&
                   std::abs(made.mesh.point(line.front()).z() - tip) < 1e-6;
        }));
    CHECK(closed == 1);
    for (const int c : corners_of_regions(made.mesh, lines)) CHECK(c == 4);
}

TEST_CASE("a sphere is parted into four-sided regions around eight vertices", "[field][oracle]") {
    Field made(test::triangle_sphere(10.0, around));
    CHECK(made.topology.singularities.size() == 8);
    const auto lines = cage::field_lines(made.mesh, made.field, made.topology, poll);
    for (const int c : corners_of_regions(made.mesh, lines)) CHECK(c == 4);
}

TEST_CASE("a plate with a hole gets four irregular vertices around it on either side",
          "[field][oracle]") {
    // The outer corners take four quarters, so that the inside needs four vertices of valence 5.
    const Field made(plate_with_hole());
    CHECK(made.topology.singularities.size() == 8);
    for (const cage::Singularity& s : made.topology.singularities) CHECK(s.valence == 5);
}

}  // namespace
}  // namespace patchwright
