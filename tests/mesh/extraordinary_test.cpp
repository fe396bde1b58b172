#include "support/cages.h"

#include <patchwright/mesh/cage.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using mesh::VertexId;

TEST_CASE("extraordinary vertices are those that are not a regular grid's", "[mesh][oracle]") {
    CHECK(mesh::summarise(*test::cube(1.0).topology).extraordinary == 8);
    CHECK(mesh::summarise(*test::torus(6, 6, 3, 1).topology).extraordinary == 0);
    // An open grid: its corners have one face, where a boundary wants two and a corner one.
    CHECK(mesh::summarise(*test::grid(3, 3).topology).extraordinary == 4);
    mesh::TopologyInput corners;
    corners.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    CHECK(mesh::summarise(*test::grid(3, 3, corners).topology).extraordinary == 0);
    for (const int n : {3, 4, 5, 9}) {
        CHECK(mesh::is_extraordinary(*test::fan(n).topology, VertexId{0}) == (n != 4));
    }
}

TEST_CASE("creases make vertices regular or not by the faces between them", "[mesh][oracle]") {
    const auto extraordinary = [](std::vector<mesh::EdgeTagInput> creases, int vertex) {
        mesh::TopologyInput tags;
        tags.creases = std::move(creases);
        return mesh::is_extraordinary(*test::grid(4, 4, tags).topology, VertexId{vertex});
    };
    constexpr double sharp = mesh::infinite_sharpness;
    constexpr int middle = 12;  // neighbours 7 and 17 along u, 11 and 13 along v
    CHECK_FALSE(extraordinary({}, middle));
    CHECK_FALSE(
        extraordinary({{middle, 7, sharp}, {middle, 17, sharp}}, middle));    // straight through
    CHECK(extraordinary({{middle, 7, sharp}, {middle, 11, sharp}}, middle));  // turning
    CHECK(extraordinary({{middle, 7, sharp}}, middle));                       // a dart
    CHECK(extraordinary({{middle, 7, sharp}, {middle, 11, sharp}, {middle, 17, sharp}}, middle));
    CHECK_FALSE(extraordinary(
        {{middle, 7, sharp}, {middle, 11, sharp}, {middle, 13, sharp}, {middle, 17, sharp}},
        middle));
}
