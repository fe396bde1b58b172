// Corners where two quads between features span more than half a turn.
#include "cage/blocks/wide_corners.h"

#include "field_shape.h"

#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace patchwright {
namespace {

using geom::Vec3;

cage::Poll poll;  // never stops

constexpr double half_width = 48.0, depth = 40.0, height = 10.0;
constexpr int columns = 4, rows = 40;  // from left to right, from the border with the corner up

/// Quads on top of a prism whose outline has a corner at the origin, from where two straight edges
/// fall by `slope` to both sides.
struct Sheet {
    geom::MeshReference reference;
    cage::Blocks blocks;
    cage::EdgeCurves curves;

    explicit Sheet(double slope)
        : reference(test::prism({{{-half_width, -slope * half_width},
                                  {0.0, 0.0},
                                  {half_width, -slope * half_width},
                                  {half_width, depth},
                                  {-half_width, depth}},
                                 {{1, 2, 3}, {1, 3, 4}, {1, 4, 0}}},
                                height)) {
        for (int j = 0; j <= rows; ++j)
            for (int i = 0; i <= columns; ++i) {
                const double x = half_width * (2.0 * i / columns - 1.0), low = -slope * std::abs(x);
                blocks.points.emplace_back(x, low + (depth - low) * j / rows, height);
            }
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i)
                blocks.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        blocks.corners = {at(0, 0), at(columns / 2, 0), at(columns, 0), at(columns, rows),
                          at(0, rows)};
        for (int i = 0; i < columns; ++i)
            for (const int j : {0, rows}) add_curve(at(i, j), at(i + 1, j));
        for (int j = 0; j < rows; ++j)
            for (const int i : {0, columns}) add_curve(at(i, j), at(i, j + 1));
    }

    static int at(int i, int j) { return j * (columns + 1) + i; }

    void add_curve(int a, int b) {
        const Vec3 middle = 0.5 * (blocks.points[std::size_t(a)] + blocks.points[std::size_t(b)]);
        for (int c = 0; c < int(reference.features().curves.size()); ++c)
            if (reference.nearest_on_curve(c, middle).distance < 1e-9)
                curves[std::minmax(a, b)] = c;
    }

    void divide(double allowed) {
        cage::divide_at_wide_corners(blocks, curves, reference, allowed, poll);
    }

    /// How far the limit surface goes beyond the origin, along the line of control points from
    /// there.
    [[nodiscard]] double beyond_corner() const {
        mesh::TopologyInput input;
        cage::add_to(input, blocks);
        const auto topology = std::make_shared<const mesh::Topology>(input);
        geom::Points points(input.vertex_count, 3);
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            points.row(v) = blocks.points[std::size_t(v)].transpose();
        const subd::LimitEvaluator evaluator(topology);
        double most = 0.0;
        for (const mesh::FaceId f : topology->faces()) {
            const auto corners = topology->corners(f);
            if (topology->vertex(corners[0]).value != at(columns / 2, 0)) continue;
            for (int k = 1; k < 1000; ++k)
                most = std::max(most, -evaluator.position(points, {f, 0.0, k / 1000.0}).y());
        }
        return most;
    }
};

TEST_CASE("the limit surface stays within corners of two quads", "[cage][oracle]") {
    // Two quads over 208 degrees; edges of 24.7 along the features, and of 1 between the quads.
    Sheet sheet(0.25);
    constexpr double allowed = 0.05;
    REQUIRE(sheet.beyond_corner() > 5.0 * allowed);
    const std::vector<Vec3> before = sheet.blocks.points;
    sheet.divide(allowed);
    CHECK(sheet.beyond_corner() < allowed);
    // By (e + k (d1 + d2) / 6) / 2^k edges of 3 along x do: 24 becomes 3, 3, 6 and 12.
    CHECK(sheet.blocks.faces.size() == (columns - 2 + 2 * 4) * rows);
    CHECK(sheet.blocks.points.size() == (columns - 1 + 2 * 4) * (rows + 1));
    CHECK(std::equal(before.begin(), before.end(), sheet.blocks.points.begin()));
    CHECK(sheet.blocks.corners.size() == 5);
}

TEST_CASE("new points beside wide corners are on the model and its features", "[cage]") {
    Sheet sheet(0.25);
    // Chords of a curve: new points go to the feature, not to the middle.
    for (int i : {1, 3}) sheet.blocks.points[std::size_t(Sheet::at(i, 0))].y() += 0.4;
    sheet.divide(0.05);
    std::set<std::pair<int, int>> once;
    for (const auto& face : sheet.blocks.faces)
        for (std::size_t k = 0; k < 4; ++k) {
            const auto edge = std::minmax(face[k], face[(k + 1) % 4]);
            if (!once.emplace(edge).second) once.erase(edge);
        }
    for (const auto& [a, b] : once)
        for (const int v : {a, b}) {
            if (v < (columns + 1) * (rows + 1)) continue;
            const Vec3& p = sheet.blocks.points[std::size_t(v)];
            double least = 1.0;
            for (int c = 0; c < int(sheet.reference.features().curves.size()); ++c)
                least = std::min(least, sheet.reference.nearest_on_curve(c, p).distance);
            CHECK(least < 1e-9);
        }
    for (const Vec3& p : sheet.blocks.points) CHECK(std::abs(p.z() - height) < 1e-9);
}

TEST_CASE("creases beside wide corners are divided with their quads", "[cage]") {
    Sheet sheet(0.25);
    const int a = Sheet::at(1, rows / 2), b = Sheet::at(2, rows / 2), c = Sheet::at(3, rows / 2);
    sheet.blocks.creases = {{a, b}, {b, c}};
    sheet.divide(0.05);
    CHECK(sheet.blocks.creases.size() == 2 * 4);
    double length = 0.0;
    for (const auto& [from, to] : sheet.blocks.creases)
        length +=
            (sheet.blocks.points[std::size_t(from)] - sheet.blocks.points[std::size_t(to)]).norm();
    CHECK(length >= half_width);
}

TEST_CASE("quads stay at corners of less than half a turn, and where edges are alike", "[cage]") {
    const double slope = GENERATE(-0.25, 0.0, 0.01);
    Sheet sheet(slope);
    const auto faces = sheet.blocks.faces;
    sheet.divide(0.05);
    CHECK(sheet.blocks.faces == faces);
}

TEST_CASE("chords that another wide corner needs stay whole", "[cage]") {
    // The lower corner's inner edge belongs to a row that the right one's features cross, and that
    // one's to a column beside the lower one.
    Sheet sheet(0.25);
    cage::Blocks& blocks = sheet.blocks;
    blocks.faces = {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 7, 6}, {4, 5, 8, 7}};
    blocks.points = {{-20, -5, height}, {0, 0, height},  {20, -5, height},
                     {-20, 15, height}, {0, 15, height}, {15, 15, height},
                     {-20, 35, height}, {0, 35, height}, {20, 35, height}};
    blocks.corners = {0, 1, 2, 5, 8, 7, 6};
    sheet.curves.clear();
    sheet.divide(1e-9);
    CHECK(std::ranges::count(blocks.faces, std::vector{1, 2, 5, 4}) == 1);
    CHECK(blocks.faces.size() ==
          4 * 4);  // the others: 20 becomes 5, 5 and 10, less than half of it
    blocks.corners = {0, 1, 2, 8, 7, 6};
    sheet.divide(1e-9);
    CHECK(std::ranges::count(blocks.faces, std::vector{1, 2, 5, 4}) == 0);
}

}  // namespace
}  // namespace patchwright
