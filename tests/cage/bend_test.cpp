// Edges across which a model bends by less than what counts as sharp.
#include "rings.h"

#include <patchwright/cage/make_cage.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace patchwright {
namespace {

using geom::Vec3;
using test::check_deviation;
using test::ring_cage;
using test::Rings;
using test::Shape;
using test::shape_of;

/// A wing with dihedral from the fourth ring on, an angle to the level.
Rings cranked_wing_rings(double dihedral) {
    Rings rings = test::wing_rings();
    for (std::size_t i = 4; i < rings.size(); ++i)
        for (Vec3& p : rings[i]) p.z() += std::tan(dihedral) * (p.y() - rings[3][0].y());
    return rings;
}

/// Around the x axis, a cylinder that goes on as a cone from the third ring on; open at both ends.
Rings bent_tube_rings(double cone) {
    Rings rings;
    for (int i = 0; i <= 4; ++i) {
        const double x = 300.0 * i, radius = 300.0 - std::tan(cone) * std::max(0.0, x - 600.0);
        rings.emplace_back();
        for (int k = 0; k < 24; ++k) {
            const double angle = -2.0 * std::numbers::pi * k / 24.0;
            rings.back().emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
        }
    }
    return rings;
}

/// How many crease edges a cage has within a plane across a coordinate axis, to 1e-3 of the size.
int creases_in_plane(const mesh::Cage& cage, int axis, double at) {
    const mesh::Topology& topology = *cage.topology;
    const double near =
        1e-3 * (cage.points.colwise().maxCoeff() - cage.points.colwise().minCoeff()).maxCoeff();
    int count = 0;
    for (const mesh::EdgeId e : topology.edges())
        count += topology.sharpness(e) > 0.0 && !topology.is_boundary(e) &&
                         std::abs(cage.points(topology.start(e).value, axis) - at) < near &&
                         std::abs(cage.points(topology.end(e).value, axis) - at) < near
                     ? 1
                     : 0;
    return count;
}

}  // namespace

TEST_CASE("a bend around a wing is a crease where smooth faces would miss the tolerance",
          "[layout]") {
    const auto bent = [](double degrees) {
        const Rings rings = cranked_wing_rings(degrees * std::numbers::pi / 180.0);
        return shape_of(ring_cage(rings, {{0, 0}, {15, 0}}, true, 3));
    };
    const auto ring_in = [](const Shape& shape, double tolerance_rel) {
        const auto made = cage::make_cage(shape.reference, {.tolerance_rel = tolerance_rel});
        INFO(made.layout[0]);
        REQUIRE(made.layout[0].rfind("wing: 16 points around", 0) == 0);
        return std::pair(creases_in_plane(made.cage, 1, 1500.0), made.cage);
    };
    // Rings are 500 or 750 mm apart, so that 8 degrees are off by 9 or 13 mm: 3e-3 or 4e-3 of the
    // diagonal.
    const Shape wing = bent(8.0);
    CHECK(ring_in(wing, 5e-3).first == 0);
    const auto [creases, made] = ring_in(wing, 1e-3);
    CHECK(creases == 16);
    check_deviation(made, wing, 1e-4);
    // Tangent faces of legacy files are off by more than a degree.
    CHECK(ring_in(bent(1.0), 1e-5).first == 0);
}

TEST_CASE("a bend around a body of revolution is a crease", "[layout]") {
    const Shape tube = shape_of(ring_cage(bent_tube_rings(0.15), {}, false, 2));
    const auto made = cage::make_cage(tube.reference);
    REQUIRE(made.layout.size() == 1);
    INFO(made.layout[0]);
    REQUIRE(made.layout[0].rfind("body around an axis: 16 lines", 0) == 0);
    CHECK(creases_in_plane(made.cage, 0, 600.0) == 16);
    check_deviation(made.cage, tube, 1e-4);
}

}  // namespace patchwright
