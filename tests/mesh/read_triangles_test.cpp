#include "support/triangle_shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/read_triangles.h>

#include <catch2/catch.hpp>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace patchwright::mesh {
namespace {

using Catch::Contains;
namespace fs = std::filesystem;

/// A file that is gone at the end.
class Scratch {
  public:
    Scratch(const std::string& name, const std::string& bytes)
        : path_(fs::temp_directory_path() / ("patchwright_" + name)) {
        std::ofstream(path_, std::ios::binary) << bytes;
    }
    ~Scratch() { fs::remove(path_); }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    [[nodiscard]] const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

void put(std::string& bytes, std::uint32_t value) {
    for (int k = 0; k < 4; ++k) bytes += char(value >> 8 * k & 255);
}

std::string binary(const geom::TriangleMesh& mesh, const std::string& header) {
    std::string bytes = header;
    bytes.resize(80, ' ');
    put(bytes, std::uint32_t(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        bytes.append(12, '\0');
        for (const int v : t)
            for (Eigen::Index k = 0; k < 3; ++k)
                put(bytes, std::bit_cast<std::uint32_t>(float(mesh.points(v, k))));
        bytes.append(2, '\0');
    }
    return bytes;
}

std::string ascii(const geom::TriangleMesh& mesh, const std::string& name) {
    std::ostringstream text;
    text << "solid " << name << "\r\n";
    for (const auto& t : mesh.triangles) {
        text << "  facet normal 0 0 0\n    outer loop\n";
        for (const int v : t)
            text << "      vertex " << mesh.points(v, 0) << " +" << mesh.points(v, 1) << " "
                 << mesh.points(v, 2) << "e0\n";
        text << "    endloop\n  endfacet\n";
    }
    text << "endsolid " << name << "\n";
    return text.str();
}

const geom::TriangleMesh box = test::triangle_box(2, 3, 4);

void check_box(const TriangleFile& file) {
    CHECK(file.mesh.points.rows() == 8);
    CHECK(file.mesh.triangles.size() == 12);
    CHECK(file.repair.closed_bodies == 1);
    CHECK(geom::bounding_box(file.mesh.points).max.isApprox(Eigen::Vector3d(2, 3, 4), 1e-6));
}

TEST_CASE("STL is read in both of its forms, by what is in it", "[mesh][stl]") {
    const Scratch text("text.stl", ascii(box, "left wing"));
    const TriangleFile from_text = read_triangles(text.path());
    check_box(from_text);
    CHECK(from_text.format == "STL ASCII");
    REQUIRE(from_text.mesh.part_names.size() == 1);
    CHECK(from_text.mesh.part_names[0] == "left wing");
    CHECK(from_text.mesh.part[5] == 0);

    for (const char* header : {"made by hand", "solid but binary all the same"}) {
        const Scratch bytes("bytes.STL", binary(box, header));
        const TriangleFile from_bytes = read_triangles(bytes.path());
        check_box(from_bytes);
        CHECK(from_bytes.format == "STL binary");
        CHECK(from_bytes.repair.welded == 36 - 8);
    }
    CHECK(read_triangles(text.path(), 25.4).mesh.points.maxCoeff() == Approx(101.6));
}

TEST_CASE("polygons of an OBJ file are cut into triangles", "[mesh][stl]") {
    const Scratch file("quads.obj",
                       "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 1 3 0\n"
                       "g plate\nf 1/1 2/1 3/1 4/1\ng\nf 4 3 5\n");
    const TriangleFile read = read_triangles(file.path());
    CHECK(read.format == "OBJ");
    REQUIRE(read.mesh.triangles.size() == 3);
    CHECK(read.mesh.part == std::vector<int>{0, 0, -1});
    CHECK(read.repair.bodies == 1);
    CHECK(read.repair.free_sides == 5);
}

/// Sides by how many triangles they have.
std::map<int, int> side_counts(const geom::TriangleMesh& mesh) {
    std::map<std::pair<int, int>, int> uses;
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    std::map<int, int> counts;
    for (const auto& [side, count] : uses) ++counts[count];
    return counts;
}

TEST_CASE("cutting polygons gives no side more than two triangles", "[mesh][stl]") {
    const std::string plate = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    // Both sides of a plate are one.
    const Scratch twice("twice.obj", plate + "f 1 2 3 4\nf 4 3 2 1\n");
    const TriangleFile from_twice = read_triangles(twice.path());
    CHECK(from_twice.repair.duplicates == 2);
    CHECK(side_counts(from_twice.mesh) == std::map<int, int>{{1, 4}, {2, 1}});
    // A pillow of two quads over one diagonal, whose other vertices differ.
    const std::string ends = plate + "v 1 0.1 1\nv 0 0.9 1\n";
    const Scratch pillow("pillow.obj", ends + "f 1 2 3 4\nf 1 6 3 5\nf 1 5 3 2\nf 1 4 3 6\n");
    CHECK(side_counts(read_triangles(pillow.path()).mesh) == std::map<int, int>{{2, 12}});
    // The shorter diagonal is an edge of the neighbour.
    const Scratch taken("taken.obj", plate + "v 0 0 1\nf 1 2 3 4\nf 1 3 5\n");
    CHECK(side_counts(read_triangles(taken.path()).mesh) == std::map<int, int>{{1, 7}, {2, 1}});
}

TEST_CASE("broken files are refused in one line", "[mesh][stl]") {
    const auto message = [](const std::string& name, const std::string& bytes) {
        const Scratch file(name, bytes);
        try {
            read_triangles(file.path());
        } catch (const base::InputError& error) {
            const std::string text = error.what();
            CHECK(text.find('\n') == std::string::npos);
            CHECK(text.find(file.path().string()) == 0);
            return text;
        }
        return std::string("read");
    };
    const std::string whole = binary(box, "x"), text = ascii(box, "x");
    CHECK_THAT(message("a.stl", whole.substr(0, 400)), Contains("truncated"));
    CHECK_THAT(message("a.stl", binary(box, "solid").substr(0, 400)), Contains("truncated"));
    CHECK_THAT(message("a.stl", whole.substr(0, 60)), Contains("60 bytes are too few"));
    CHECK_THAT(message("a.stl", ""), Contains("0 bytes are too few"));
    CHECK_THAT(message("a.stl", text.substr(0, 700)), Contains("truncated"));
    CHECK_THAT(message("a.stl", text.substr(0, text.find("endsolid"))), Contains("truncated"));
    CHECK_THAT(message("a.stl", "solid x\nendsolid x\n"), Contains("holds no triangles"));
    CHECK_THAT(message("a.stl", "solid x\nfacet\nvertex 0 nan 0\n"),
               Contains("line 3: the coordinate 'nan' is not a length"));
    CHECK_THAT(message("a.stl", "solid x\nfacet\nvertex 0 0 0\nvertex 0 1 0\nendloop\n"),
               Contains("line 5: a facet has 2 vertices"));
    CHECK_THAT(message("a.stl", "solid x\nhello\n"), Contains("'hello' is no word of an STL file"));
    CHECK_THAT(message("a.obj", "v 0 0 0\nf 1 2 3\n"), Contains("line 2"));
    CHECK_THAT(message("a.obj", "v 0 0 0\n"), Contains("holds no triangles"));
    geom::TriangleMesh broken = box;
    broken.points(0, 0) = std::numeric_limits<double>::infinity();
    CHECK_THAT(message("a.stl", binary(broken, "x")), Contains("not finite"));
    // Not a number beside numbers, which a maximum passes over.
    for (Eigen::Index k = 0; k < 3; ++k) {
        broken = box;
        broken.points(2, k) = std::numeric_limits<double>::quiet_NaN();
        CHECK_THAT(message("a.stl", binary(broken, "x")), Contains("not finite"));
    }
    CHECK_THROWS_WITH(read_triangles("/nowhere/a.stl"), Contains("cannot be opened"));
}

}  // namespace
}  // namespace patchwright::mesh
