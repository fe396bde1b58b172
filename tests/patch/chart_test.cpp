#include "support/cages.h"
#include "support/joints.h"

#include <patchwright/patch/extract.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace patchwright;

namespace {

std::size_t charts_of(const mesh::Cage& cage) {
    return patch::extract(cage).patches.patches.size();
}

}  // namespace

TEST_CASE("regular regions are one chart, however fine", "[patch]") {
    CHECK(charts_of(test::cube(2.0)) == 6);
    CHECK(charts_of(subd::refine(test::cube(2.0), 3)) == 6);
    CHECK(charts_of(test::grid(7, 5)) == 1);
    CHECK(charts_of(test::fan(5)) == 5);
    CHECK(charts_of(subd::refine(test::fan(5), 2)) == 5);
}

TEST_CASE("rings are cut so that no chart has a seam", "[patch]") {
    CHECK(charts_of(test::torus(8, 6, 3, 1)) == 4);
    CHECK(charts_of(test::torus(100, 100, 3, 1)) == 4);
    CHECK(charts_of(test::torus(3, 3, 3, 1)) == 4);
}

TEST_CASE("a strip that winds round and borders on itself is cut along", "[patch]") {
    // Four turns of eight quads; the strip's sides are one crease, a helix.
    constexpr int turn = 8, turns = 4, count = turn * turns;
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    mesh::TopologyInput tags;
    for (int k = 0; k <= count + turn; ++k) {
        const double angle = 2.0 * M_PI * k / turn;
        points.emplace_back(std::cos(angle), std::sin(angle), double(k) / turn);
        if (k < count) faces.push_back({k, k + 1, k + turn + 1, k + turn});
        if (k < count + turn) tags.creases.push_back({k, k + 1, mesh::infinite_sharpness});
    }
    CHECK(patch::extract(test::make_cage(points, faces, tags)).patches.patches.size() == turns);
}

TEST_CASE("creases bound charts", "[patch]") {
    mesh::TopologyInput tags;
    // Across the middle of a 4 x 4 grid.
    for (int i = 0; i < 4; ++i)
        tags.creases.push_back({5 * i + 2, 5 * i + 7, mesh::infinite_sharpness});
    const auto extraction = patch::extract(test::grid(4, 4, tags));
    CHECK(extraction.patches.patches.size() == 2);
    CHECK(patch::crease_midpoints(extraction.patches).rows() == 1);
    // A crease that ends inside needs borders at its end.
    tags.creases.resize(2);
    CHECK(charts_of(test::grid(4, 4, tags)) == 4);
}

TEST_CASE("a border that ends on another splits the side it meets", "[patch]") {
    // An L of three blocks of 2 x 2 quads has one vertex with three faces on its boundary; the
    // borders from there end on the other side.
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    const auto at = [](int i, int j) { return 5 * i + j; };
    for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 5; ++j) points.emplace_back(i, j, 0.1 * i * j);
    }
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            if (i < 2 || j < 2)
                faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    // The points of the missing block come last so that they can be left away.
    std::vector<int> number(points.size(), -1);
    std::vector<geom::Vec3> used;
    for (auto& face : faces) {
        for (int& v : face) {
            if (number[std::size_t(v)] < 0) {
                number[std::size_t(v)] = int(used.size());
                used.push_back(points[std::size_t(v)]);
            }
            v = number[std::size_t(v)];
        }
    }
    const auto set = patch::extract(test::make_cage(used, faces)).patches;
    CHECK(set.patches.size() == 3);
    std::size_t split_sides = 0;
    for (const patch::Patch& patch : set.patches) {
        for (const auto& side : patch.sides) split_sides += side.size() > 1 ? 1 : 0;
    }
    CHECK(set.edges.size() == 10);
    CHECK(split_sides == 0);
}

TEST_CASE("long sides are split where corners of others meet them", "[patch]") {
    std::size_t split_sides = 0;
    for (unsigned seed = 0; seed < 12; ++seed) {
        const mesh::Cage cage = test::random_cage(seed, {.open = seed % 2 == 1, .crease_share = 0});
        const auto set = patch::extract(cage).patches;
        for (const patch::Patch& patch : set.patches) {
            for (const auto& side : patch.sides) split_sides += side.size() > 1 ? 1 : 0;
        }
        CHECK(set.patches.size() <=
              patch::extract(cage, {.covering = patch::Covering::Faces}).patches.patches.size());
    }
    CHECK(split_sides > 0);
}

TEST_CASE("charts that many others end on are cut", "[patch]") {
    // A prism of 100 sides with sharp rims: 100 patches a cap, and a side that is regular.
    constexpr int sides = 100;
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces(2);
    mesh::TopologyInput tags;
    for (const int ring : {0, 1}) {
        for (int k = 0; k < sides; ++k) {
            const double a = 2 * M_PI * k / sides;
            points.emplace_back(std::cos(a), std::sin(a), ring);
            tags.creases.push_back(
                {ring * sides + k, ring * sides + (k + 1) % sides, mesh::infinite_sharpness});
            faces[std::size_t(ring)].push_back(ring == 0 ? sides - 1 - k : sides + k);
        }
    }
    for (int k = 0; k < sides; ++k) {
        const int on = (k + 1) % sides;
        faces.push_back({k, on, sides + on, sides + k});
    }
    const auto set = patch::extract(test::make_cage(points, faces, tags)).patches;
    std::vector<int> uses(set.edges.size(), 0);
    for (const patch::Patch& patch : set.patches) {
        std::size_t edges = 0;
        for (const auto& side : patch.sides) {
            edges += side.size();
            for (const patch::EdgeUse& use : side) ++uses[std::size_t(use.edge)];
        }
        CHECK(edges <= 64);
    }
    CHECK(std::all_of(uses.begin(), uses.end(), [](int count) { return count == 2; }));
    CHECK(set.patches.size() < 1.1 * 2 * sides);
}
