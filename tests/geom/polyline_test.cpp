#include "geom/polyline.h"

#include "geom/angle.h"

#include <patchwright/geom/nearest.h>

#include <catch2/catch.hpp>

namespace patchwright::geom {
namespace {

const Polyline corner{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}};

TEST_CASE("points, parts and distances of a line by arc length", "[geom]") {
    CHECK(length_of(corner) == 4.0);
    CHECK(arc_lengths(corner) == std::vector<double>{0.0, 3.0, 4.0});
    CHECK(point_along(corner, 0.5).isApprox(Vec3(2, 0, 0)));
    CHECK(point_along(corner, 1.0).isApprox(Vec3(3, 1, 0)));
    const Polyline part = part_of(corner, 0.5, 0.875);
    REQUIRE(part.size() == 3);
    CHECK(part.front().isApprox(Vec3(2, 0, 0)));
    CHECK(part.back().isApprox(Vec3(3, 0.5, 0)));
    CHECK(distance_to(corner, Vec3(1, 2, 0)) == Approx(2.0));
    CHECK(distance_to(corner, Vec3(4, 1, 0)) == Approx(1.0));
}

TEST_CASE("the angle between directions is exact where its cosine is not", "[geom]") {
    CHECK(angle_between({1, 0, 0}, {1, 1e-9, 0}) == Approx(1e-9));
    CHECK(angle_between({2, 0, 0}, {-3, 0, 0}) == Approx(M_PI));
}

TEST_CASE("the nearest point of a segment is at its ends or at the foot of the perpendicular",
          "[geom]") {
    const Vec3 a(1, 0, 0), b(3, 0, 4);
    const Vec3 along = (b - a).normalized(), aside(0, 2, 0);
    for (const double share : {0.0, 0.3, 1.0}) {
        const SegmentPoint near = nearest_on_segment(a + share * (b - a) + aside, a, b);
        CHECK(near.share == Approx(share).margin(1e-15));
        CHECK((near.point - (a + share * (b - a))).norm() < 1e-14);
    }
    CHECK(nearest_on_segment(a - along + aside, a, b).point == a);
    CHECK(nearest_on_segment(b + along + aside, a, b).point.isApprox(b));
    const SegmentPoint of_point = nearest_on_segment(b, a, a);
    CHECK(of_point.share == 0.0);
    CHECK(of_point.point == a);
}

}  // namespace
}  // namespace patchwright::geom
