#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

#include <sstream>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

mesh::BuildResult parse(const std::string& text) {
    std::istringstream stream(text);
    return mesh::read_obj(stream, "test.obj");
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("an OBJ cage with all tags survives writing and reading to the last bit", "[mesh]") {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const mesh::Cage cage = test::random_cage(
            seed,
            {.open = seed % 2 == 1, .semi_sharp = true, .rule = mesh::BoundaryRule::EdgeAndCorner});
        const std::string text = mesh::obj_text(cage);
        const mesh::Cage again = parse(text).cage;
        CHECK(again.points == cage.points);
        CHECK(mesh::obj_text(again) == text);
    }
}

TEST_CASE("names, pins and OpenSubdiv tags are read", "[mesh]") {
    const auto result =
        parse(square +
              "v 2 0 0\nv 2 1 0\ng left side\nf 1/1 2//2 3/3/3 -3\no right\nf 2 5 6 3\n"
              "t crease 2/1/0 1 2 3.5\nt corner 1/1/0 4 10\n"
              "t interpolateboundary 1/0/0 2\n#patchwright pin 0\n# a comment\n");
    const mesh::Topology& t = *result.cage.topology;
    REQUIRE(t.face_count() == 2);
    CHECK(t.group_names() == std::vector<std::string>{"left side", "right"});
    CHECK(t.group(mesh::FaceId{1}) == 1);
    CHECK(t.boundary_rule() == mesh::BoundaryRule::EdgeAndCorner);
    CHECK(t.is_pinned(mesh::VertexId{0}));
    CHECK(std::isinf(t.tagged_sharpness(mesh::VertexId{4})));
    int creases = 0;
    for (const mesh::EdgeId e : t.edges()) {
        if (t.tagged_sharpness(e) == 3.5) ++creases;
    }
    CHECK(creases == 1);
}

TEST_CASE("unusable OBJ files are refused with file, element and reason", "[mesh][errors]") {
    const auto [text, part] = GENERATE_COPY(table<std::string, std::string>({
        {"", "holds no vertices"},
        {square, "holds no faces"},
        {square + "f 1 2 3 9\n", "line 5: face 0 names vertex 9"},
        {square + "f 1 2 3 0\n", "names vertex 0"},
        {square + "f 1 2\n", "at least 3"},
        {square + "f 1 2 2 3\nf 1 3 4\n", "face 0 has vertex 1 twice"},
        {"v 0 0 nan\n", "vertex 0 has the coordinate 'nan'"},
        {"v 0 0 inf\n", "not finite"},
        {"v 0 0\n", "three coordinates"},
        {"v 0 0 x\n", "'x' is not a number"},
        {square + "f 1 2 3 4\nf 2 3 4 1\n", "same vertices"},
        {square + "f 1 2 3\n", "vertex 3 belongs to no face"},
        {square + "v 0 0 1\nv 0 0 2\nf 1 2 3 4\nf 1 2 5\nf 2 1 6\n",
         "edge 0-1 has more than two faces"},
        {square + "v 2 1 0\nv 2 2 0\nv 1 2 0\nf 1 2 3 4\nf 3 5 6 7\n", "vertex 2 joins parts"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 2 1\n", "crease 0-2: there is no such edge"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 1 -1\n", "sharpness -1"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 1\n", "fewer arguments"},
        {square + "f 1 2 3 4\nt corner 1/1/0 7 1\n", "names vertex 7"},
        {square + "f 1 2 3 4\nt interpolateboundary 1/0/0 3\n", "interpolateboundary"},
    }));
    CAPTURE(text);
    CHECK_THROWS_WITH(parse(text), Contains("test.obj") && Contains(part) && !Contains("\n"));
    CHECK_THROWS_AS(parse(text), base::InputError);
}

TEST_CASE("a Moebius strip is refused", "[mesh][errors]") {
    CHECK_THROWS_WITH(parse("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
                            "f 1 2 4 3\nf 3 4 6 5\nf 5 6 1 2\n"),
                      Contains("one-sided"));
}

TEST_CASE("an inner vertex with two faces is refused", "[mesh][errors]") {
    CHECK_THROWS_WITH(parse(square + "v 0.5 0.5 0\nf 1 2 5 4\nf 2 3 4 5\n"),
                      Contains("only 2 faces"));
}

TEST_CASE("disagreeing faces are turned, and closed parts face outward", "[mesh]") {
    auto faces = test::cube_faces;
    std::reverse(faces[2].begin() + 1, faces[2].end());
    SECTION("one face") {}
    SECTION("most faces") {
        for (auto& face : faces) std::reverse(face.begin() + 1, face.end());
    }
    mesh::TopologyInput input;
    input.vertex_count = 8;
    for (const auto& face : faces) {
        input.face_sizes.push_back(4);
        input.face_vertices.insert(input.face_vertices.end(), face.begin(), face.end());
    }
    const mesh::Cage reference = test::cube(2.0);
    const auto result = mesh::build_cage(input, reference.points);
    CHECK((result.flipped_faces == 1 || result.flipped_faces == 5));
    for (const mesh::FaceId f : reference.topology->faces()) {
        const auto a = reference.topology->corners(f);
        const auto b = result.cage.topology->corners(f);
        CHECK(reference.topology->vertex(a[1]) == result.cage.topology->vertex(b[1]));
    }
}
