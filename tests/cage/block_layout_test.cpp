#include "cage/blocks/divisions.h"

#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

namespace patchwright {
namespace {

using cage::Vec2;

cage::Poll poll;  // never stops

cage::QuadLayout with_arcs(const std::vector<double>& wanted) {
    cage::QuadLayout made;
    for (const double w : wanted) {
        cage::LayoutArc arc;
        arc.wanted = w;
        made.arcs.push_back(arc);
    }
    return made;
}

cage::LayoutBlock block(std::array<std::vector<int>, 4> sides) {
    cage::LayoutBlock made;
    for (std::size_t s = 0; s < 4; ++s)
        for (const int arc : sides[s]) made.sides[s].push_back({arc, false});
    return made;
}

TEST_CASE("a plane quad piece that is convex stays as it is in the plane", "[layout]") {
    // Mean value coordinates give linear functions back: with the border where it is, so is the
    // rest.
    constexpr int n = 5;
    std::vector<geom::Vec3> points;
    std::vector<std::array<int, 3>> triangles;
    std::vector<std::pair<int, int>> order;
    for (int i = 0; i < n; ++i) order.emplace_back(i, 0);
    for (int j = 0; j < n; ++j) order.emplace_back(n, j);
    for (int i = n; i > 0; --i) order.emplace_back(i, n);
    for (int j = n; j > 0; --j) order.emplace_back(0, j);
    const std::size_t border_count = order.size();
    for (int j = 1; j < n; ++j)
        for (int i = 1; i < n; ++i) order.emplace_back(i, j);
    std::map<std::pair<int, int>, int> number;
    std::vector<Vec2> border;
    for (const auto& [i, j] : order) {
        number[{i, j}] = int(points.size());
        // Inner points are not even.
        const double x = i + (i > 0 && i < n ? 0.2 * std::sin(3.0 * i + 5.0 * j) : 0.0);
        const bool inner = points.size() >= border_count;
        points.emplace_back(inner ? x : i, j, 0.0);
        if (!inner) border.emplace_back(i, j);
    }
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const int a = number[{i, j}], b = number[{i + 1, j}], c = number[{i + 1, j + 1}],
                      d = number[{i, j + 1}];
            triangles.push_back({a, b, c});
            triangles.push_back({a, c, d});
        }
    }
    const cage::FlatPiece piece(points, triangles, border);
    for (const Vec2& p : {Vec2(0.3, 0.4), Vec2(2.5, 2.5), Vec2(4.9, 1.1), Vec2(5.0, 5.0)}) {
        const auto place = piece.at(p);
        CHECK((place.point - geom::Vec3(p.x(), p.y(), 0.0)).norm() < 1e-10);
        CHECK(place.normal.isApprox(geom::Vec3::UnitZ(), 1e-12));
    }
}

TEST_CASE("opposite sides of blocks get equal numbers near the wanted ones", "[layout]") {
    // A cube: arcs along x, y and z, four each, with lengths for 2, 3 and 5 edges.
    cage::QuadLayout cube = with_arcs({2, 2, 2, 2, 3, 3, 3, 3, 5, 5, 5, 5});
    cube.blocks = {block({{{0}, {4}, {1}, {5}}}),  block({{{2}, {6}, {3}, {7}}}),
                   block({{{0}, {8}, {2}, {9}}}),  block({{{1}, {10}, {3}, {11}}}),
                   block({{{4}, {8}, {6}, {10}}}), block({{{5}, {9}, {7}, {11}}})};
    const auto divisions = cage::divide_arcs(cube, poll);
    for (std::size_t a = 0; a < cube.arcs.size(); ++a)
        CHECK(divisions.edges[a] == int(cube.arcs[a].wanted));
    for (const cage::Valence3Insertion& one : divisions.insertions) CHECK(one.count == 0);
}

TEST_CASE("sides of several arcs add up", "[layout]") {
    // Two open blocks beside one: 0 on the left is opposite 1 and 2, which go on to 3 and 4.
    cage::QuadLayout made = with_arcs({7, 2, 3, 2, 3, 1, 1, 1, 1, 1});
    made.blocks = {block({{{5}, {1, 2}, {6}, {0}}}), block({{{7}, {3}, {8}, {1}}}),
                   block({{{8}, {4}, {9}, {2}}})};
    const auto divisions = cage::divide_arcs(made, poll);
    CHECK(divisions.edges[0] == divisions.edges[1] + divisions.edges[2]);
    CHECK(divisions.edges[1] == divisions.edges[3]);
    CHECK(divisions.edges[2] == divisions.edges[4]);
    // Between 5, which the parts want, and 7.
    CHECK(divisions.edges[0] >= 5);
    CHECK(divisions.edges[0] <= 7);
}

TEST_CASE("where sums cannot agree strips go around a corner", "[layout]") {
    // A ring of one block whose left side is arc 0 and whose right side is arcs 0 and 1: without a
    // valence-3 insertion arc 1 would have no edge. Arcs 2 and 3 are free, 1 is too.
    cage::QuadLayout made = with_arcs({2, 1, 4, 4});
    made.blocks = {block({{{2}, {0, 1}, {3}, {0}}})};
    const auto divisions = cage::divide_arcs(made, poll);
    for (const int n : divisions.edges) CHECK(n >= 1);
    const cage::Valence3Insertion& made_there = divisions.insertions[0];
    REQUIRE(made_there.count > 0);
    for (int k = 0; k < 2; ++k) {
        const auto& sides = made.blocks[0].sides;
        CHECK(cage::edges_of(sides[std::size_t((made_there.side + k) % 4)], divisions) ==
              cage::edges_of(sides[std::size_t((made_there.side + k + 2) % 4)], divisions) +
                  made_there.count);
    }
}

}  // namespace
}  // namespace patchwright
