// Blocks along the faces of models whose CAD is the limit surface of a cage that only the test
// knows.
#include "shape.h"
#include "support/cages.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit.h>
#include <patchwright/measure/fairness.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

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

/// The surface of a plate of m x n square holes of one cell (10 mm) each, all edges sharp.
/// @param round  whether the walls of holes are smooth, and their rims without corners
mesh::Cage plate_with_holes(int m, int n, bool round = false) {
    const auto is_solid = [&](int i, int j, int k) {
        const auto inside = [](int c, int holes) { return c >= 0 && c <= 2 * holes; };
        return inside(i, m) && inside(j, n) && k == 0 && (i % 2 == 0 || j % 2 == 0);
    };
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces;
    std::map<std::array<int, 3>, int> numbers;
    std::map<std::pair<int, int>, std::set<int>> sides_of;  // of an edge, by where they face
    for (int i = 0; i <= 2 * m; ++i)
        for (int j = 0; j <= 2 * n; ++j)
            for (int side = 0; side < 6 && is_solid(i, j, 0); ++side) {
                const int axis = side / 2, up = side % 2;
                std::array<int, 3> beside{i, j, 0};
                beside[std::size_t(axis)] += 2 * up - 1;
                if (is_solid(beside[0], beside[1], beside[2])) continue;
                std::vector<int> face;
                for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
                    std::array<int, 3> p{i, j, 0};
                    p[std::size_t(axis)] += up;
                    p[std::size_t((axis + 1) % 3)] += up == 1 ? u : v;
                    p[std::size_t((axis + 2) % 3)] += up == 1 ? v : u;
                    const auto [known, fresh] = numbers.emplace(p, int(points.size()));
                    if (fresh) points.emplace_back(10.0 * p[0], 10.0 * p[1], 10.0 * p[2]);
                    face.push_back(known->second);
                }
                for (std::size_t k = 0; k < 4; ++k)
                    sides_of[std::minmax(face[k], face[(k + 1) % 4])].insert(side);
                faces.push_back(std::move(face));
            }
    mesh::TopologyInput tags;
    const auto is_outside = [&](int v) {
        const Vec3& p = points[std::size_t(v)];
        const double far_x = 10.0 * (2 * m + 1), far_y = 10.0 * (2 * n + 1);
        return p.x() == 0.0 || p.y() == 0.0 || p.x() == far_x || p.y() == far_y;
    };
    for (const auto& [edge, sides] : sides_of) {
        const bool upright =
            points[std::size_t(edge.first)].z() != points[std::size_t(edge.second)].z();
        if (sides.size() > 1 && !(round && upright && !is_outside(edge.first)))
            tags.creases.push_back({edge.first, edge.second, mesh::infinite_sharpness});
    }
    return test::make_cage(points, faces, tags);
}

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

TEST_CASE("faces with holes become rectangles between the holes", "[layout]") {
    constexpr int n = 4;
    const Shape shape = shape_of(plate_with_holes(n, n));
    const auto made = cage::make_cage(shape.reference, {.method = cage::Method::Aligned});
    REQUIRE(made.from_faces);
    const mesh::Topology& topology = *made.cage.topology;
    CHECK(topology.is_closed());
    // Five quads meet in each of a hole's eight corners.
    CHECK(mesh::summarise(topology).extraordinary == 8 * n * n);
    // Cuts follow the triangles' edges, which are not quite at right angles to the sides.
    CHECK(measure::measure_fairness(made.cage).least_angle_rad > 80.0 / 180.0 * M_PI);
    CHECK(fitted_distance(made.cage, shape) < 1e-10);
}

TEST_CASE("two rows of many holes are cut between neighbours", "[layout]") {
    constexpr int holes = 20;
    const Shape shape = shape_of(plate_with_holes(2, holes));
    const auto made = cage::make_cage(shape.reference, {.method = cage::Method::Aligned});
    REQUIRE(made.from_faces);
    CHECK(mesh::summarise(*made.cage.topology).extraordinary == 8 * 2 * holes);
    // The border of all joined holes is long, and the nearest corners are near along it, too: cuts
    // that had to end farther away left lines along four holes, and angles of 5 degrees.
    CHECK(measure::measure_fairness(made.cage).least_angle_rad > 45.0 / 180.0 * M_PI);
    CHECK(fitted_distance(made.cage, shape) < 1e-10);
}

TEST_CASE("a body that is its own mirror image gets such a cage, however it lies", "[layout]") {
    const Eigen::Isometry3d placed = Eigen::Translation3d(300.0, -200.0, 50.0) *
                                     Eigen::AngleAxisd(0.7, Vec3(1.0, -2.0, 0.5).normalized());
    const bool round = GENERATE(false, true);
    mesh::Cage plate = plate_with_holes(3, 1, round);
    for (Eigen::Index i = 0; i < plate.points.rows(); ++i)
        plate.points.row(i) = placed * Vec3(plate.points.row(i));
    const Shape shape = shape_of(plate);
    const auto made = cage::make_cage(shape.reference, {.method = cage::Method::Aligned});
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    CHECK(made.layout[0].find("its own mirror image") != std::string::npos);
    CHECK(made.layout[0].find("as a whole") == std::string::npos);
    CHECK(made.cage.topology->is_closed());
    // Across the middle of the plate, 70 mm long.
    const Vec3 normal = placed.linear() * Vec3::UnitX(), middle = placed * Vec3(35.0, 0.0, 0.0);
    const auto& points = made.cage.points;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Vec3 p = points.row(i);
        const Vec3 image = p - 2.0 * normal.dot(p - middle) * normal;
        CHECK((points.rowwise() - image.transpose()).rowwise().norm().minCoeff() < 1e-6);
    }
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

}  // namespace patchwright
