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
        {square + "f 1 2 3 9\n", "line 5: face 1 names vertex 9"},
        {square + "f 1 2 3 0\n", "names vertex 0"},
        {square + "f 1 2\n", "at least 3"},
        {square + "f 1 2 2 3\nf 1 3 4\n", "face 1 (line 5) has vertex 2 (line 2) twice"},
        {"v 0 0 nan\n", "line 1: vertex 1 has the coordinate 'nan'"},
        {"v 0 0 inf\n", "not a length"},
        {"v 0 0 -1e71\n", "not a length up to 1e+70"},
        {"v 0 0\n", "three coordinates"},
        {"v 0 0 x\n", "'x' is not a number"},
        {square + "f 1 2 3 4\nf 2 3 4 1\n",
         "face 1 (line 5) and face 2 (line 6) have the same vertices"},
        {square + "f 1 2 3\n", "vertex 4 (line 4) belongs to no face"},
        {square + "v 0 0 1\nv 0 0 2\nf 1 2 3 4\nf 1 2 5\nf 2 1 6\n",
         "edge 1-2 has more than two faces: face 1 (line 7), face 2 (line 8), face 3 (line 9)"},
        {square + "v 2 1 0\nv 2 2 0\nv 1 2 0\nf 1 2 3 4\nf 3 5 6 7\n",
         "vertex 3 (line 3) joins parts"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 2 1\n",
         "crease 0-2 (line 6): there is no such edge (tags count from 0)"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 1 -1\n", "sharpness -1"},
        {square + "f 1 2 3 4\nt crease 2/1/0 0 1\n", "fewer arguments"},
        {square + "f 1 2 3 4\nt corner 1/1/0 7 1\n", "corner 7 (line 6): there are 4 vertices"},
        {square + "f 1 2 3 4\n#patchwright pin 4\n", "pin 4 (line 6): there are 4 vertices"},
        {square + "f 1 2 3 4\n#patchwright sector 0 1 90\n",
         "sector 0 1 (line 6): there are 1 faces"},
        {square + "f 1 2 3 4\n#patchwright sector 0 0 360\n", "angle 360 degrees"},
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

TEST_CASE("an inner vertex with two faces goes where nothing else goes with it", "[mesh]") {
    const auto faces = [](const mesh::BuildResult& r) {
        std::vector<int> sizes;
        for (const mesh::FaceId f : r.cage.topology->faces())
            sizes.push_back(r.cage.topology->size(f));
        return sizes;
    };
    // Two quads that share two edges of a square's diagonal, the fifth vertex in its middle.
    const std::string bent = "v 9 9 9\n" + square + "v 0.5 0.5 0\nv 2 0 0\n";
    const std::string polygons = "f 2 3 6 5\nf 3 4 5 6\nf 3 7 1 4\n";
    const auto result = parse(bent + polygons);
    CHECK(result.removed_vertices == 1);
    CHECK(faces(result) == std::vector<int>{3, 3, 4});
    CHECK(result.cage.points.row(5) == Eigen::RowVector3d(2, 0, 0));

    // Creases on both of its edges are one afterwards, and tags on later vertices move along.
    const auto sharp = parse(bent + polygons +
                             "t crease 2/1/0 2 5 3\nt crease 2/1/0 5 4 3\nt corner 1/1/0 6 10\n"
                             "#patchwright pin 6\n");
    CHECK(sharp.removed_vertices == 1);
    CHECK(std::isinf(sharp.cage.topology->tagged_sharpness(mesh::VertexId{5})));
    CHECK(sharp.cage.topology->is_pinned(mesh::VertexId{5}));
    for (const mesh::EdgeId e : sharp.cage.topology->edges()) {
        const int a = sharp.cage.topology->start(e).value, b = sharp.cage.topology->end(e).value;
        const bool across = std::min(a, b) == 2 && std::max(a, b) == 4;
        CHECK(sharp.cage.topology->tagged_sharpness(e) == (across ? 3.0 : 0.0));
    }

    for (const char* tag : {"t crease 2/1/0 2 5 3\n", "t corner 1/1/0 5 2\n",
                            "#patchwright pin 5\n", "#patchwright sector 5 0 0 0 0 1\n"}) {
        CAPTURE(tag);
        CHECK_THROWS_WITH(parse(bent + polygons + tag), Contains("vertex 6 (line 6) has only 2"));
    }
    // The edge that would be made is there already: it would have four faces.
    CHECK_THROWS_WITH(parse("v 1 0 0\nv 0 0 1\nv 0 1 0\nv 0 -1 0\nv 0 0 0\nf 1 3 5 4\nf 2 4 5 3\n"
                            "f 3 1 4\nf 4 2 3\n"),
                      Contains("has only 2 faces"));
    // A triangle would have two vertices left.
    CHECK_THROWS_WITH(parse(square + "v 0.5 0.5 0\nf 1 2 5\nf 2 3 4 1 5\n"),
                      Contains("has only 2 faces"));
}

TEST_CASE("messages count vertices as the file does after one was removed", "[mesh][errors]") {
    // Vertex 5 goes; 8 belongs to two fans.
    const std::string text = square +
                             "v 0.5 0.5 0\nv 2 0 0\nv 2 1 0\nv 5 5 5\nv 6 5 5\nv 5 6 5\n"
                             "v 4 5 5\nv 5 4 5\nf 1 2 5 4\nf 2 3 4 5\nf 2 6 7 3\n"
                             "f 8 9 10\nf 8 11 12\n";
    CHECK_THROWS_WITH(parse(text), Contains("vertex 8 (line 8) joins parts"));
    CHECK_THROWS_WITH(parse(text.substr(0, text.find("f 8 11")) +
                            "v 1 1 8\nv 1 2 8\nf 11 12 13\nf 12 14 13\nt crease 2/1/0 10 7 1\n"),
                      Contains("crease 7-10"));
}

TEST_CASE("a sector needs two sharp edges around it", "[mesh][errors]") {
    const std::string cube =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    const std::string sector = "#patchwright sector 0 0 90\n", dart = "t crease 2/1/0 0 2 10\n";
    CHECK_THROWS_WITH(parse(cube + sector), Contains("two infinitely sharp edges"));
    CHECK_THROWS_WITH(parse(cube + dart + sector), Contains("two infinitely sharp edges"));
    CHECK_NOTHROW(parse(cube + dart + "t crease 2/1/0 0 1 10\n" + sector));
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
