// Wings, blades and nacelles whose CAD is the limit surface of a cage that only the test knows.
#include "cage/sections/part_left_out.h"
#include "rings.h"

#include <patchwright/cage/make_cage.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace patchwright {
namespace {

using geom::Vec3;
using test::check_deviation;
using test::ring_cage;
using test::Rings;
using test::section;
using test::Shape;
using test::shape_of;
using test::wing_rings;

/// Along y, then round a bend of 80 degrees and up; sections turn with the way.
Rings winglet_rings() {
    constexpr double straight = 3000.0, radius = 300.0, up = 900.0, bend = 1.4;
    Rings rings;
    for (int i = 0; i <= 14; ++i) {
        const double roll = bend * std::clamp((i - 6) / 4.0, 0.0, 1.0),
                     along = straight * std::min(i / 6.0, 1.0), past = up * std::max(i - 10, 0) / 4;
        const double way = along + radius * roll + past, chord = 1000.0 - 0.18 * way;
        const double y = along + radius * std::sin(roll) + past * std::cos(roll),
                     z = radius * (1.0 - std::cos(roll)) + past * std::sin(roll);
        rings.emplace_back();
        for (const Eigen::Vector2d& p : section(0.12, 0.006))
            rings.back().emplace_back(chord * p.x() + 0.3 * way, y - std::sin(roll) * chord * p.y(),
                                      z + std::cos(roll) * chord * p.y());
    }
    return rings;
}

/// From a circle to a thin section along z, twisted; open at both ends.
Rings blade_rings() {
    Rings rings;
    for (int i = 0; i <= 12; ++i) {
        const double t = i / 12.0, s = std::clamp((t - 0.1) / 0.35, 0.0, 1.0),
                     blend = s * s * (3.0 - 2.0 * s);
        const double chord = 500.0 + 900.0 * blend * (1.0 - t), twist = 0.4 * (1.0 - t);
        const auto thin = section(0.2, 0.004);
        rings.emplace_back();
        for (int k = 0; k < 16; ++k) {
            const double angle = 2.0 * std::numbers::pi * (k + 0.5) / 16.0;
            const Eigen::Vector2d round(250.0 * std::cos(angle), -250.0 * std::sin(angle));
            const Eigen::Vector2d p =
                blend * chord * (thin[std::size_t(k)] - Eigen::Vector2d(0.35, 0.0)) +
                (1.0 - blend) * round;
            rings.back().emplace_back(-std::cos(twist) * p.x() + std::sin(twist) * p.y(),
                                      std::sin(twist) * p.x() + std::cos(twist) * p.y(),
                                      10000.0 * t);
        }
    }
    return rings;
}

/// x and radius from the inner rim round the lip to the nozzle.
Rings nacelle_rings() {
    constexpr std::array<std::array<double, 2>, 13> profile{{{700, 440},
                                                             {500, 445},
                                                             {300, 455},
                                                             {120, 475},
                                                             {20, 500},
                                                             {-10, 530},
                                                             {20, 560},
                                                             {150, 590},
                                                             {500, 620},
                                                             {1000, 630},
                                                             {1500, 600},
                                                             {2000, 520},
                                                             {2400, 430}}};
    Rings rings;
    for (const auto& [x, radius] : profile) {
        rings.emplace_back();
        for (int k = 0; k < 24; ++k) {
            const double angle = -2.0 * std::numbers::pi * k / 24.0;
            rings.back().emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
        }
    }
    return rings;
}

std::vector<Vec3> extraordinary(const mesh::Cage& cage) {
    std::vector<Vec3> result;
    for (const mesh::VertexId v : cage.topology->vertices())
        if (mesh::is_extraordinary(*cage.topology, v))
            result.emplace_back(cage.points.row(v.value));
    return result;
}

/// Both ends of every sharp edge lie on a sharp curve of the shape.
void check_creases(const mesh::Cage& cage, const Shape& shape) {
    const mesh::Topology& topology = *cage.topology;
    int creases = 0;
    for (const mesh::EdgeId e : topology.edges()) {
        if (topology.sharpness(e) == 0.0 || topology.is_boundary(e)) continue;
        ++creases;
        for (const mesh::VertexId v : {topology.start(e), topology.end(e)}) {
            const auto foot = shape.reference.feature_point(cage.points.row(v.value).transpose(),
                                                            geom::FeatureKind::Sharp);
            REQUIRE(foot);
            // Ends are moved inward by a fifty thousandth of the span, and open ones to the rim.
            CHECK(foot->distance < 1e-3 * shape.reference.bounds().diagonal());
        }
    }
    CHECK(creases > 0);
}

TEST_CASE("a twisted wing with a blunt trailing edge gets rings and two lids", "[layout]") {
    const Shape wing = shape_of(ring_cage(wing_rings(), {{0, 0}, {15, 0}}, true));
    const auto made = cage::make_cage(wing.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("wing: 16 points around", 0) == 0);
    CHECK(made.layout[0].find("blunt trailing edge, ends planar and planar") != std::string::npos);
    CHECK(made.method == cage::Method::Aligned);
    CHECK(made.cage.topology->is_closed());
    CHECK(made.cage.topology->all_quads());
    for (const Vec3& p : extraordinary(made.cage)) CHECK((p.y() < 1.0 || p.y() > 2999.0));
    check_creases(made.cage, wing);
    // The quads of the nose lie at the leading edge: x = 400 t - chord / 4 before the twist.
    const mesh::Topology& topology = *made.cage.topology;
    int at_nose = 0;
    for (const mesh::FaceId f : topology.faces()) {
        if (topology.group_names()[std::size_t(topology.group(f))] != "nose") continue;
        ++at_nose;
        const auto corners = topology.corners(f);
        for (int k = 0; k < 4; ++k) {
            const Vec3 p = made.cage.points.row(topology.vertex(corners[k]).value);
            const double t = p.y() / 3000.0, chord = 1000.0 - 500.0 * t;
            CHECK(std::abs(p.x() - (400.0 * t - 0.25 * chord)) < 0.05 * chord);
        }
    }
    CHECK(at_nose >= 5);
    check_deviation(made.cage, wing, 1e-4);
}

TEST_CASE("a winglet gets rings across it, as the wing does", "[layout]") {
    const Shape wing = shape_of(ring_cage(winglet_rings(), {{0, 0}, {15, 0}}, true));
    const auto made = cage::make_cage(wing.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("wing: 16 points around", 0) == 0);
    CHECK(made.layout[0].find("blunt trailing edge, ends planar and planar") != std::string::npos);
    const double top = wing.reference.bounds().max.z();
    for (const Vec3& p : extraordinary(made.cage)) CHECK((p.y() < 1.0 || p.z() > top - 50.0));
    // Rings of the winglet's upper half lie across it, 80 degrees from the level.
    for (Eigen::Index ring = 0; ring + 16 <= made.cage.points.rows(); ring += 16) {
        const auto rows = made.cage.points.middleRows(ring, 16);
        if (rows.col(2).minCoeff() < 0.6 * top) continue;
        const Eigen::VectorXd along = rows.col(1) * std::cos(1.4) + rows.col(2) * std::sin(1.4);
        CHECK(along.maxCoeff() - along.minCoeff() < 10.0);
    }
    check_creases(made.cage, wing);
    check_deviation(made.cage, wing, 1e-3);
}

TEST_CASE("a winglet is left out by sections that end before it", "[layout]") {
    const Rings rings = winglet_rings();
    const Rings straight(rings.begin(), rings.begin() + 7);
    const std::map<int, int> tail{{0, 0}, {15, 0}};
    const Shape whole = shape_of(ring_cage(rings, tail, true)),
                wing = shape_of(ring_cage(straight, tail, true));
    const geom::SurfaceMesh mesh = wing.reference.surface_mesh(1.0),
                            other = whole.reference.surface_mesh(1.0);
    cage::Poll no_limit;  // never stops
    const auto body = cage::bodies_of(mesh), longer = cage::bodies_of(other);
    const cage::WingSearch search = cage::find_wing(body[0], wing.reference, {}, no_limit);
    REQUIRE(search.wing);
    CHECK(!cage::part_left_out(body[0], *search.wing, search.blocks, no_limit));
    const auto place = cage::part_left_out(longer[0], *search.wing, search.blocks, no_limit);
    REQUIRE(place);
    // At the winglet's tip, within a triangle.
    const double top = whole.reference.bounds().max.z();
    CHECK(std::abs(place->z() - top) < 100.0);
}

/// The same with a line of points along the nose, open at both ends.
Rings nosed_wing_rings() {
    Rings rings = wing_rings();
    for (auto& ring : rings)
        ring.insert(ring.begin() + 8,
                    ring[7] + 0.4 * (ring[7] - ring[6]) + 0.5 * (ring[8] - ring[7]));
    return rings;
}

TEST_CASE("a nose that is sharp on a part of the span gets a line", "[layout]") {
    const Shape wing = shape_of(ring_cage(nosed_wing_rings(), {{0, 0}, {16, 0}, {8, 2}}, false));
    const auto made = cage::make_cage(wing.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    CHECK(made.layout[0].find("line along the nose") != std::string::npos);
    // Sharp edges but those of the trailing edge lie along the nose, from the third ring to the
    // tip.
    const auto& curves = wing.reference.features().curves;
    const mesh::Topology& topology = *made.cage.topology;
    double length = 0.0, sharp = 0.0;
    for (const mesh::EdgeId e : topology.edges()) {
        if (topology.sharpness(e) == 0.0 || topology.is_boundary(e)) continue;
        const Vec3 a = made.cage.points.row(topology.start(e).value),
                   b = made.cage.points.row(topology.end(e).value);
        const double t = (a.y() + b.y()) / 6000.0, chord = 1000.0 - 500.0 * t;
        if (0.5 * (a.x() + b.x()) < 400.0 * t) length += (b - a).norm();
        CHECK(std::abs(a.y() - b.y()) > 0.1 * chord);
    }
    for (const auto& curve : curves)
        if (curve.kind == geom::FeatureKind::Sharp &&
            curve.start.x() < 400.0 * curve.start.y() / 3000.0)
            sharp += curve.length;
    CHECK(sharp > 1000.0);
    CHECK(length > 0.98 * sharp);
    check_deviation(made.cage, wing, 1e-4);
}

TEST_CASE("a blade's thick round root gets the same rings, its trailing edge fades", "[layout]") {
    const Shape blade = shape_of(ring_cage(blade_rings(), {{0, 0}, {15, 0}}, false));
    const auto made = cage::make_cage(blade.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("blade: 16 points around", 0) == 0);
    CHECK(made.cage.topology->all_quads());
    CHECK(extraordinary(made.cage).empty());
    check_creases(made.cage, blade);
    check_deviation(made.cage, blade, 1e-4);
}

TEST_CASE("a nacelle gets rings around its lip", "[layout]") {
    const Shape nacelle = shape_of(ring_cage(nacelle_rings(), {}, false));
    const auto made = cage::make_cage(nacelle.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("nacelle: 16 lines", 0) == 0);
    const mesh::Topology& topology = *made.cage.topology;
    CHECK(topology.all_quads());
    CHECK(extraordinary(made.cage).empty());
    int free = 0;
    for (const mesh::EdgeId e : topology.edges()) free += topology.is_boundary(e) ? 1 : 0;
    CHECK(free == 2 * 16);
    // Rings are plane circles around the x axis, as the shape is one of revolution.
    for (int ring = 0; ring + 16 <= int(made.cage.points.rows()); ring += 16) {
        const auto rows = made.cage.points.middleRows(ring, 16);
        const Eigen::VectorXd radii = rows.rightCols(2).rowwise().norm();
        CHECK(rows.col(0).maxCoeff() - rows.col(0).minCoeff() < 2.0);
        CHECK(radii.maxCoeff() - radii.minCoeff() < 2.0);
    }
    check_deviation(made.cage, nacelle, 1e-4);
}

TEST_CASE("a body around an axis is closed by a square of quads at each end", "[layout]") {
    mesh::Cage cage = test::cube(2.0);
    cage.points = cage.points * Eigen::Vector3d(500.0, 200.0, 200.0).asDiagonal();
    const Shape body = shape_of(cage);
    const auto made = cage::make_cage(body.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("body around an axis: 16 lines", 0) == 0);
    CHECK(made.cage.topology->is_closed());
    CHECK(made.cage.topology->all_quads());
    CHECK(extraordinary(made.cage).size() == 8);
    check_deviation(made.cage, body, 1e-4);
}

TEST_CASE("what is no wing and no nacelle says why", "[layout]") {
    mesh::TopologyInput tags;
    for (int a = 0; a < 8; ++a)
        for (const int bit : {1, 2, 4})
            if ((a & bit) == 0) tags.creases.push_back({a, a | bit, mesh::infinite_sharpness});
    const Shape box = shape_of(test::cube(100.0, std::move(tags)));
    const auto made = cage::make_cage(box.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    CHECK(made.from_faces);
    CHECK(made.layout[0].find("no wing (") != std::string::npos);
    CHECK(made.layout[0].find("no nacelle (") != std::string::npos);
}

}  // namespace
}  // namespace patchwright
