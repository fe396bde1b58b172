// Blocks along the faces of models whose CAD is the limit surface of a cage that only the test
// knows.
#include "cage/blocks/untangle.h"
#include "shape.h"
#include "support/cages.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright {
namespace {

using geom::Vec3;
using test::Shape;
using test::shape_of;

/// Of all samples after a fit, of the diagonal.
double fitted_distance(const mesh::Cage& cage, const Shape& shape) {
    const double diagonal = shape.reference.bounds().diagonal();
    const auto result =
        fit::fit(cage, shape.reference,
                 {.tolerance_mm = 1e-4 * diagonal, .preserve_parametrisation = false});
    return result.levels[std::size_t(result.best_level)].max_mm / diagonal;
}

/// Points and faces of a flat bottom with a sharp rim of four corners and a smooth dome over it:
/// both meet with one corner each in every corner of the rim.
struct Cushion {
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces = test::cube_faces;
    mesh::TopologyInput tags;

    Cushion() {
        for (int v = 0; v < 8; ++v) {
            const double half = v < 4 ? 50.0 : 25.0;
            points.emplace_back(half * (2 * (v & 1) - 1), half * (2 * (v >> 1 & 1) - 1),
                                v < 4 ? 0.0 : 20.0);
        }
        for (const auto& [a, b] : {std::array{0, 1}, {1, 3}, {3, 2}, {2, 0}})
            tags.creases.push_back({a, b, mesh::infinite_sharpness});
        for (int v = 0; v < 4; ++v) tags.corners.push_back({v, mesh::infinite_sharpness});
    }
};

}  // namespace

TEST_CASE("a box is laid out in its six faces", "[layout]") {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces)
        for (std::size_t k = 0; k < 4; ++k)
            if (face[k] < face[(k + 1) % 4])
                tags.creases.push_back({face[k], face[(k + 1) % 4], mesh::infinite_sharpness});
    mesh::Cage cage = test::cube(2.0, tags);
    cage.points = cage.points * Eigen::Vector3d(60.0, 40.0, 20.0).asDiagonal();
    const auto made = cage::make_cage(shape_of(cage).reference, {.method = cage::Method::Aligned});
    const mesh::CageSummary summary = mesh::summarise(*made.cage.topology);
    CHECK(made.method == cage::Method::Aligned);
    CHECK(made.cage.topology->is_closed());
    CHECK(summary.non_quads == 0);
    CHECK(summary.extraordinary == 0);
    CHECK(summary.corners == 8);
    // Edges are at most 0.3 of the diagonal long: 3, 2 and 1 along the sides, one more at most.
    CHECK(summary.faces <= 2 * (4 * 3 + 3 * 2 + 4 * 2));
}

TEST_CASE("two faces that meet in their corners become blocks with three quads there", "[layout]") {
    const Cushion cushion;
    const Shape shape = shape_of(test::make_cage(cushion.points, cushion.faces, cushion.tags));
    const auto made = cage::make_cage(shape.reference, {.method = cage::Method::Aligned});
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    CHECK(made.from_faces);
    const mesh::Topology& topology = *made.cage.topology;
    CHECK(topology.is_closed());
    CHECK(topology.all_quads());
    // Of a frame around a square, and the corners of the rim.
    CHECK(mesh::summarise(topology).extraordinary <= 8);
    CHECK(mesh::summarise(topology).corners == 4);
    CHECK(fitted_distance(made.cage, shape) < 1e-4);
}

TEST_CASE("bodies that are nothing known are laid out along their faces beside known ones",
          "[layout]") {
    Cushion both;
    // A smooth body around an axis, as in aero_test.cpp, above it.
    for (int v = 0; v < 8; ++v)
        both.points.emplace_back(250.0 * (2 * (v & 1) - 1), 100.0 * (2 * (v >> 1 & 1) - 1),
                                 300.0 + 100.0 * (2 * (v >> 2) - 1));
    for (const auto& face : test::cube_faces) {
        both.faces.push_back(face);
        for (int& v : both.faces.back()) v += 8;
    }
    const Shape shape = shape_of(test::make_cage(both.points, both.faces, both.tags));
    const auto made = cage::make_cage(shape.reference);
    REQUIRE(made.layout.size() == 2);
    INFO(made.layout[0] << "\n" << made.layout[1]);
    CHECK(made.method == cage::Method::Aligned);
    CHECK(made.from_faces);
    const auto told = [&](const char* what) {
        return std::count_if(made.layout.begin(), made.layout.end(), [&](const std::string& text) {
            return text.find(what) != std::string::npos;
        });
    };
    CHECK(told("body around an axis") == 1);
    CHECK(told("blocks along its faces") == 1);
    CHECK(made.cage.topology->is_closed());
    CHECK(fitted_distance(made.cage, shape) < 1e-4);
    // Without blocks the others are remeshed, and the known one stays as it is.
    const auto without = cage::make_cage(shape.reference, {.blocks = cage::BlockWay::None});
    CHECK(without.recognised == 1);
    CHECK(without.method == cage::Method::Remesh);
    CHECK_FALSE(without.from_faces);
    CHECK(without.cage.topology->is_closed());
}

TEST_CASE("folded quads are opened, well formed ones stay", "[layout]") {
    const Shape shape = shape_of(test::grid(6, 6));  // in the plane z = 0
    constexpr int n = 5;
    std::vector<Vec3> points;
    std::vector<cage::Freedom> freedom;
    std::vector<std::vector<int>> faces;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const bool inside = i > 0 && j > 0 && i + 1 < n && j + 1 < n;
            points.emplace_back(1.0 + i, 1.0 + j, 0.0);
            freedom.push_back({inside, -1});
            const int v = i * n + j;
            if (i + 1 < n && j + 1 < n) faces.push_back({v, v + n, v + n + 1, v + 1});
        }
    }
    const auto least_sine = [&] {
        double least = 1.0;
        for (const auto& face : faces)
            for (int k = 0; k < 4; ++k)
                least = std::min(least, cage::corner_sine(points, face, k, Vec3(0.0, 0.0, 1.0)));
        return least;
    };
    cage::Poll poll;
    const std::vector<Vec3> even = points;
    cage::untangle(faces, points, freedom, shape.reference, poll);
    CHECK(points == even);
    // Beyond the line of the next points: the quads there are folded.
    points[2 * n + 2] += Vec3(1.15, 0.2, 0.0);
    REQUIRE(least_sine() < -0.5);
    cage::untangle(faces, points, freedom, shape.reference, poll);
    CHECK(least_sine() > 0.15);  // what counts as well formed
    for (std::size_t v = 0; v < points.size(); ++v) {
        CHECK(std::abs(points[v].z()) < 1e-12);
        if (!freedom[v].free) CHECK(points[v] == even[v]);
    }
}

}  // namespace patchwright
