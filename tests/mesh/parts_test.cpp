#include "support/cages.h"

#include <patchwright/mesh/obj.h>
#include <patchwright/mesh/parts.h>

#include <catch2/catch.hpp>

using namespace patchwright;

TEST_CASE("parts of a cage keep their tags and make the whole again", "[mesh]") {
    mesh::TopologyInput tags;
    const auto& side = test::cube_faces[0];
    tags.creases = {{side[0], side[1], 2.5}, {side[1], side[2], mesh::infinite_sharpness}};
    tags.corners = {{3, mesh::infinite_sharpness}};
    tags.pins = {5};
    const mesh::Cage cube = test::cube(2.0, tags);
    mesh::Cage plate = test::grid(3, 2);
    plate.points.col(2).setConstant(7.0);
    const mesh::Cage both = mesh::joined({cube, plate, cube});
    CHECK(both.topology->face_count() == 6 + 6 + 6);
    CHECK_FALSE(both.topology->is_closed());
    const auto parts = mesh::connected_parts(both);
    REQUIRE(parts.size() == 3);
    CHECK(mesh::obj_text(parts[0]) == mesh::obj_text(cube));
    CHECK(mesh::obj_text(parts[1]) == mesh::obj_text(plate));
    CHECK(mesh::obj_text(parts[2]) == mesh::obj_text(cube));
    CHECK(mesh::obj_text(mesh::joined(parts)) == mesh::obj_text(both));
    CHECK(mesh::connected_parts(cube).size() == 1);
}
