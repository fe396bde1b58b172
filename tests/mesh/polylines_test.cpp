#include <patchwright/base/error.h>
#include <patchwright/mesh/polylines.h>

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>

using namespace patchwright;

namespace {

/// What a file with this text holds.
std::vector<mesh::Polyline> read(const std::string& text) {
    std::string folder = (std::filesystem::temp_directory_path() / "polylines-XXXXXX").string();
    REQUIRE(::mkdtemp(folder.data()) != nullptr);
    const std::filesystem::path file = std::filesystem::path(folder) / "lines.obj";
    std::ofstream(file) << text;
    struct Removed {
        const std::string& folder;
        ~Removed() { std::filesystem::remove_all(folder); }
    } const removed{folder};
    return mesh::read_polylines(file);
}

const std::string four_points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("polylines come back to the last bit", "[mesh]") {
    std::vector<mesh::Polyline> given(3);
    given[0].points = geom::Points::Random(5, 3) / 3.0;
    given[1] = {1e9 * geom::Points::Random(3, 3), true};
    given[2].points = 1e-9 * geom::Points::Random(2, 3);
    const auto found = read(mesh::polylines_text(given));
    REQUIRE(found.size() == given.size());
    for (std::size_t i = 0; i < given.size(); ++i) {
        CHECK(found[i].points == given[i].points);
        CHECK(found[i].closed == given[i].closed);
    }
    const mesh::PolylineSummary summary = mesh::summarise(found);
    CHECK(summary.count == 3);
    CHECK(summary.closed == 1);
    CHECK(summary.points == 10);
}

TEST_CASE("edges by themselves are joined where two of them meet", "[mesh]") {
    auto found = read(four_points + "l 3 2\nl 1 2\nl 3 4\n");
    REQUIRE(found.size() == 1);
    CHECK(found[0].points.rows() == 4);
    CHECK_FALSE(found[0].closed);
    found = read(four_points + "l 1 2\nl 3 4\nl 2 3\nl 4 1\n");
    REQUIRE(found.size() == 1);
    CHECK(found[0].points.rows() == 4);
    CHECK(found[0].closed);
    CHECK(read(four_points + "l 1 2\nl 1 3\nl 1 4\n").size() == 3);
    found = read(four_points + "l 1 2 3\nl 3 4\n");
    REQUIRE(found.size() == 2);
    CHECK(found[0].line == 5);
    CHECK(found[1].line == 6);
    // Two edges between the same points are a way there and back.
    CHECK(read(four_points + "l 1 2\nl 2 1\n").size() == 1);
}

TEST_CASE("files without polylines are told apart", "[mesh][errors]") {
    CHECK(read(four_points + "f 1 2 3 4\nl 1 99\n").empty());
    for (const char* bad : {"", "l 1 5\n", "l 1\n", "l 1 1\n", "l 1 x\n"})
        CHECK_THROWS_AS(read(four_points + bad), base::InputError);
}
