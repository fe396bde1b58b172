#include "support/triangle_shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <random>

namespace patchwright::geom {
namespace {

using test::triangle_box;
using test::triangle_cylinder;
using test::triangle_sphere;

constexpr double radius = 50.0;
constexpr int around = 96;
/// Of an arc between two neighbouring points, times two: triangles bend both ways.
const double chord = 2.0 * radius * (1.0 - std::cos(M_PI / around));

TEST_CASE("foot points on a triangulated sphere are the sphere's within its chords",
          "[geom][mesh][oracle]") {
    const MeshReference sphere(triangle_sphere(radius, around));
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
        const Vec3 query = (radius + 20.0 * std::sin(i)) * direction;
        const FootPoint foot = sphere.foot_point(query);
        CHECK(std::abs(foot.distance - std::abs(query.norm() - radius)) < chord);
        CHECK(std::abs(foot.point.norm() - radius) < chord);
        CHECK(foot.distance == Approx((query - foot.point).norm()));
        CHECK(sphere.point_on_face(foot.face, foot.uv).point.isApprox(foot.point, 1e-12));
        // Blended normals: much nearer than the half step of 1.9 degrees that facets are off.
        CHECK(foot.normal.dot(foot.point.normalized()) > std::cos(0.5 * M_PI / 180.0));
    }
}

TEST_CASE("curvature of a triangulated sphere is 1/r away from the poles", "[geom][mesh][oracle]") {
    const MeshReference sphere(triangle_sphere(radius, around));
    for (int i = 0; i < 200; ++i) {
        const double t = 0.5 + 2.1 * i / 200.0, p = 0.7 * i;
        const Vec3 query =
            radius * Vec3(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t));
        const auto bend = sphere.curvature(sphere.foot_point(query));
        REQUIRE(bend);
        for (const double value : bend->value) CHECK(value == Approx(-1.0 / radius).epsilon(0.05));
    }
    CHECK(sphere.features().curves.empty());
    CHECK(sphere.features().corners.empty());
    CHECK(sphere.region_count() == 1);
    CHECK(sphere.chord_error() > 0.2 * chord);
    CHECK(sphere.chord_error() < 2.0 * chord);
}

TEST_CASE("a triangulated box has twelve sharp curves between eight corners",
          "[geom][mesh][oracle]") {
    const MeshReference box(triangle_box(2, 3, 4));
    const Features& features = box.features();
    REQUIRE(features.curves.size() == 12);
    CHECK(features.corners.size() == 8);
    CHECK(box.region_count() == 6);
    double length = 0.0;
    for (const FeatureCurve& curve : features.curves) {
        CHECK(curve.kind == FeatureKind::Sharp);
        CHECK(curve.least_angle_rad == Approx(M_PI / 2));
        CHECK_FALSE(curve.closed);
        length += curve.length;
    }
    CHECK(length == Approx(4.0 * (2 + 3 + 4)));
    for (const FeatureCorner& corner : features.corners) {
        CHECK(corner.kind == CornerKind::Junction);
        CHECK(corner.curves.size() == 3);
    }
    const auto edge = box.feature_point({1.0, -1.0, -2.0}, FeatureKind::Sharp);
    REQUIRE(edge);
    CHECK(edge->point.isApprox(Vec3(1, 0, 0), 1e-12));
    CHECK(edge->distance == Approx(std::sqrt(5.0)));
    CHECK_FALSE(box.feature_point({1, 1, 1}, FeatureKind::Free));
    CHECK(box.feature_point({3, 3, 5}, FeatureKind::Corner)->point.isApprox(Vec3(2, 3, 4), 1e-12));
    // Flat sides are flat to their borders: normals are not blended across edges.
    CHECK(box.foot_point({1.999, 1, 5}).normal.isApprox(Vec3(0, 0, 1), 1e-12));
    CHECK(box.chord_error() == Approx(0.0).margin(1e-12));
}

TEST_CASE("nearest points on one side of a triangulated box are on its rectangle",
          "[geom][mesh][oracle]") {
    const Vec3 size(2, 3, 4);
    const MeshReference box(triangle_box(size.x(), size.y(), size.z()));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-0.5, 1.5);
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<char> faces;
        for (int t = 0; t < int(box.mesh().triangles.size()); ++t)
            faces.push_back(box.point_on_face(t, {0.3, 0.3}).normal[axis] > 0.5 ? 1 : 0);
        CHECK(std::count(faces.begin(), faces.end(), char(1)) == 2);
        for (int i = 0; i < 100; ++i) {
            const Vec3 query = Vec3(unit(random), unit(random), unit(random)).cwiseProduct(size);
            Vec3 expected = query.cwiseMax(Vec3::Zero()).cwiseMin(size);
            expected[axis] = size[axis];
            const FootPoint foot = box.foot_point_on(faces, query);
            CHECK(foot.point.isApprox(expected, 1e-12));
            CHECK(foot.normal.isApprox(Vec3::Unit(axis), 1e-12));
        }
    }
    CHECK_THROWS_AS(box.foot_point_on({1, 1}, Vec3::Zero()), base::InvalidArgument);
}

TEST_CASE("borders of triangles know what is left and right of their curve", "[geom][mesh]") {
    const MeshReference box(triangle_box(2, 3, 4));
    const std::vector<FaceBorder> borders = box.face_borders();
    CHECK(borders.size() == 18);
    int on_curves = 0;
    for (const FaceBorder& b : borders) {
        REQUIRE(b.left >= 0);
        REQUIRE(b.right >= 0);
        if (b.curve < 0) continue;
        ++on_curves;
        const FeatureCurve& curve = box.features().curves[std::size_t(b.curve)];
        const FootPoint left = box.point_on_face(b.left, {0.3, 0.3});
        const FootPoint right = box.point_on_face(b.right, {0.3, 0.3});
        const Vec3 along = curve.end - curve.start;
        CHECK(left.normal.cross(along).dot(left.point - curve.start) > 0.0);
        CHECK(right.normal.cross(along).dot(right.point - curve.start) < 0.0);
    }
    CHECK(on_curves == 12);
}

TEST_CASE("a triangulated cylinder has two closed curves", "[geom][mesh][oracle]") {
    const MeshReference cylinder(triangle_cylinder(10.0, 30.0, 36));
    const Features& features = cylinder.features();
    REQUIRE(features.curves.size() == 2);
    CHECK(features.corners.empty());
    CHECK(cylinder.region_count() == 3);
    const double whole = 36 * 2.0 * 10.0 * std::sin(M_PI / 36);
    for (int c = 0; c < 2; ++c) {
        const FeatureCurve& curve = features.curves[std::size_t(c)];
        CHECK(curve.closed);
        CHECK(curve.length == Approx(whole));
        // Round and round, and pieces across the start.
        const Vec3 at = cylinder.point_on_curve(c, 0.25 * whole).point;
        CHECK(cylinder.point_on_curve(c, 2.25 * whole).point.isApprox(at, 1e-9));
        CHECK(cylinder.point_on_curve(c, -0.75 * whole).point.isApprox(at, 1e-9));
        const auto near = cylinder.nearest_on_curve(c, at);
        CHECK(near.arc_length == Approx(0.25 * whole));
        const ArcRange across{0.9 * whole, 1.1 * whole};
        const auto within = cylinder.nearest_on_curve(c, at, across);
        CHECK(within.point.isApprox(cylinder.point_on_curve(c, 0.1 * whole).point, 1e-9));
    }
    for (int i = 0; i < 50; ++i) {
        const double p = 0.13 * i;
        const auto bend =
            cylinder.curvature(cylinder.foot_point({10 * std::cos(p), 10 * std::sin(p), 15.0}));
        REQUIRE(bend);
        CHECK(bend->value[0] == Approx(-0.1).epsilon(0.05));
        CHECK(bend->value[1] == Approx(0.0).margin(0.005));
        CHECK(std::abs(bend->direction[1].z()) > 0.99);
    }
}

TEST_CASE("on a thin plate the side that is asked for is taken", "[geom][mesh]") {
    const MeshReference plate(triangle_box(100, 100, 2));
    const Vec3 query(40, 50, 1.9);
    CHECK(plate.foot_point(query).point.z() == Approx(2.0));
    CHECK(plate.foot_point(query, Vec3(0, 0, -1)).point.z() == Approx(0.0).margin(1e-12));
    // Farther behind than the reach, 2 % of the diagonal, the nearest one is the answer.
    const MeshReference slab(triangle_box(100, 100, 5));
    CHECK(slab.foot_point({40, 50, 4.9}, Vec3(0, 0, -1)).point.z() == Approx(5.0));
}

TEST_CASE("an open mesh ends in free curves, and a cone's tip is a corner", "[geom][mesh]") {
    TriangleMesh tube = triangle_cylinder(10.0, 30.0, 36);
    TriangleMesh open{tube.points, {}, {}, {}};
    for (std::size_t t = 0; t < tube.triangles.size(); ++t)
        if (t % 4 < 2) open.triangles.push_back(tube.triangles[t]);
    make_sound(open, "tube");
    const MeshReference reference(open);
    REQUIRE(reference.features().curves.size() == 2);
    for (const FeatureCurve& curve : reference.features().curves)
        CHECK(curve.kind == FeatureKind::Free);

    // The upper end's middle lifted: a cone of 45 degrees.
    tube.points(2 * 36 + 1, 2) = 40.0;
    const MeshReference pointed(tube);
    REQUIRE(pointed.features().corners.size() == 1);
    CHECK(pointed.features().corners[0].kind == CornerKind::Apex);
    CHECK(pointed.features().corners[0].point.isApprox(Vec3(0, 0, 40), 1e-12));
}

TEST_CASE("samples of a mesh stand for its area and lie on it", "[geom][mesh][oracle]") {
    const MeshReference sphere(triangle_sphere(radius, around));
    double area = 0.0;
    for (const SurfaceSample& s : sphere.sample(5000)) {
        area += s.weight;
        CHECK(sphere.foot_point(s.point).distance < 1e-9 * radius);
    }
    // Chords take 1e-3 of it away.
    CHECK(area == Approx(4.0 * M_PI * radius * radius).epsilon(0.01));
    CHECK_THROWS_AS(sphere.sample(0), base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright::geom
