#include "support/cages.h"

#include <patchwright/mesh/chords.h>

#include <catch2/catch.hpp>

#include <set>

using namespace patchwright;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::VertexId;

namespace {

std::vector<char> chord_of(const mesh::Chords& chords, EdgeId e) {
    std::vector<char> chosen(std::size_t(chords.count), 0);
    chosen[std::size_t(chords.of_edge[e.index()])] = 1;
    return chosen;
}

}  // namespace

TEST_CASE("chords run through opposite edges", "[mesh]") {
    CHECK(mesh::find_chords(*test::cube(2.0).topology).count == 3);
    CHECK(mesh::find_chords(*test::grid(3, 5).topology).count == 8);
    CHECK(mesh::find_chords(*test::torus(6, 4, 3.0, 1.0).topology).count == 10);
}

TEST_CASE("splitting a chord adds regular vertices only and keeps tags", "[mesh]") {
    mesh::TopologyInput tags;
    tags.creases.push_back({0, 1, mesh::infinite_sharpness});
    tags.creases.push_back({0, 2, 2.5});
    tags.pins = {3};
    tags.corners.push_back({5, 4.0});
    const mesh::Cage cube = test::cube(2.0, tags);
    const mesh::Topology& t = *cube.topology;
    const mesh::Chords chords = mesh::find_chords(t);
    for (const EdgeId e : t.edges()) {
        const auto fine = split_chords(t, chords, chord_of(chords, e));
        const mesh::Topology& s = *fine.topology;
        CHECK(s.vertex_count() == 12);
        CHECK(s.face_count() == 10);
        CHECK(s.is_closed());
        CHECK(s.vertex_count() - s.edge_count() + s.face_count() == 2);
        for (const VertexId v : s.vertices()) {
            CHECK(s.valence(v) == (v.value < 8 ? 3 : 4));
        }
        CHECK(s.is_pinned(VertexId{3}));
        CHECK(s.tagged_sharpness(VertexId{5}) == 4.0);
        double infinite = 0, semi = 0;
        for (const EdgeId x : s.edges()) {
            infinite += std::isinf(s.tagged_sharpness(x)) ? 1 : 0;
            semi += s.tagged_sharpness(x) == 2.5 ? 1 : 0;
        }
        const auto twice = [&](int a, int b) {
            for (const EdgeId x : t.edges()) {
                if (std::minmax(t.start(x).value, t.end(x).value) == std::minmax(a, b))
                    return chords.of_edge[x.index()] == chords.of_edge[e.index()] ? 2 : 1;
            }
            return 0;
        };
        CHECK(infinite == twice(0, 1));
        CHECK(semi == twice(0, 2));
    }
}

TEST_CASE("children keep their parent's axes and know their origin", "[mesh][oracle]") {
    const mesh::Cage grid = test::grid(3, 2);
    const mesh::Topology& t = *grid.topology;
    const auto chords = mesh::find_chords(t);
    std::vector<char> all(std::size_t(chords.count), 1);
    const auto fine = split_chords(t, chords, all);
    REQUIRE(fine.topology->face_count() == 24);
    std::set<std::pair<double, double>> places;
    geom::Points points(fine.topology->vertex_count(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const auto& at = fine.vertices[std::size_t(v)];
        const auto corner = [&](int i) {
            return grid.points.row(t.vertex(t.corners(at.face)[i]).value);
        };
        points.row(v) = (1 - at.u) * (1 - at.v) * corner(0) + at.u * (1 - at.v) * corner(1) +
                        at.u * at.v * corner(2) + (1 - at.u) * at.v * corner(3);
        places.insert({points(v, 0), points(v, 1)});
    }
    CHECK(places.size() == std::size_t(points.rows()));
    for (const FaceId f : fine.topology->faces()) {
        const auto corner = [&](const mesh::Topology& of, FaceId face, const geom::Points& p,
                                int i) {
            return Eigen::RowVector3d(p.row(of.vertex(of.corners(face)[i]).value));
        };
        const FaceId parent = fine.parents[f.index()];
        for (const int side : {1, 3}) {
            const Eigen::RowVector3d child =
                corner(*fine.topology, f, points, side) - corner(*fine.topology, f, points, 0);
            const Eigen::RowVector3d whole =
                corner(t, parent, grid.points, side) - corner(t, parent, grid.points, 0);
            CHECK((2 * child - whole).norm() < 1e-12);
        }
    }
}
