// Bodies that are their own mirror images: their planes, halves and mirrored blocks.
#include "cage/symmetry/mirror_blocks.h"
#include "field_shape.h"
#include "support/triangle_shapes.h"

#include <patchwright/base/numbers.h>
#include <patchwright/mesh/cage.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace patchwright {
namespace {

using geom::Vec3;

cage::Poll poll;  // never stops

constexpr double half_width = 30.0, wall = 40.0, ridge = 60.0, height = 25.0;

/// A house's outline, with corners in the middle of its bottom and at the ridge, as a prism. Its
/// planes are x = 0 and z = height / 2; the section with the first is 170 mm long, with the other
/// 212.
geom::TriangleMesh house() {
    return test::prism({{{-half_width, 0.0},
                         {0.0, 0.0},
                         {half_width, 0.0},
                         {half_width, wall},
                         {0.0, ridge},
                         {-half_width, wall}},
                        {{0, 1, 5}, {1, 2, 3}, {1, 3, 5}, {5, 3, 4}}},
                       height);
}

struct Body {
    geom::MeshReference reference;
    geom::SurfaceMesh mesh;
    cage::SurfaceBody body;

    explicit Body(geom::TriangleMesh triangles)
        : reference(std::move(triangles)), mesh(reference.surface_mesh(0.0)) {
        body.mesh = &mesh;
        body.triangles.resize(mesh.triangles.size());
        std::iota(body.triangles.begin(), body.triangles.end(), 0);
    }
    Body(const Body&) = delete;

    [[nodiscard]] std::optional<cage::MirrorPlane> plane(double within_mm) const {
        return mirror_plane(body, reference, within_mm, poll);
    }
};

double area_of(const geom::SurfaceMesh& mesh) {
    double area = 0.0;
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.points.row(t[0]), b = mesh.points.row(t[1]), c = mesh.points.row(t[2]);
        area += 0.5 * (b - a).cross(c - a).norm();
    }
    return area;
}

struct HalfHouse {
    Body house{patchwright::house()};
    std::unique_ptr<cage::HalfSurface> half =
        cage::HalfSurface::of(house.body, house.reference, {Vec3::UnitX(), 0.0}, poll);
};

/// The last one, as lines of the section are, that a point is on.
int feature_number(const geom::ModelSurface& surface, const Vec3& p) {
    int c = int(surface.features().curves.size()) - 1;
    while (c >= 0 && surface.nearest_on_curve(c, p).distance > 1e-9) --c;
    return c;
}

/// One quad a face of the half house: bottom, wall, roof and both gables.
cage::BlocksOnCurves quads_of(const cage::HalfSurface& half) {
    cage::BlocksOnCurves made;
    for (const double z : {0.0, height})
        for (const auto& [x, y] :
             {std::pair{0.0, 0.0}, {half_width, 0.0}, {half_width, wall}, {0.0, ridge}})
            made.blocks.points.emplace_back(x, y, z);
    made.blocks.faces = {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {0, 3, 2, 1}, {4, 5, 6, 7}};
    for (const auto& face : made.blocks.faces)
        for (std::size_t k = 0; k < 4; ++k) {
            const auto edge = std::minmax(face[k], face[(k + 1) % 4]);
            const Vec3 middle = 0.5 * (made.blocks.points[std::size_t(edge.first)] +
                                       made.blocks.points[std::size_t(edge.second)]);
            const int curve = feature_number(half, middle);
            if (made.curves.emplace(edge, curve).second && !half.is_section(curve))
                made.blocks.creases.push_back(edge);
        }
    made.blocks.corners = {0, 1, 2, 3, 4, 5, 6, 7};
    return made;
}

}  // namespace

TEST_CASE("of several planes that of the shortest section is found, however a body lies",
          "[layout][oracle]") {
    const Eigen::Isometry3d placed = Eigen::Translation3d(4e3, -7e3, 1e3) *
                                     Eigen::AngleAxisd(0.7, Vec3(1.0, -2.0, 0.5).normalized());
    geom::TriangleMesh mesh = house();
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i)
        mesh.points.row(i) = placed * Vec3(mesh.points.row(i));
    const auto plane = Body(std::move(mesh)).plane(1e-3);
    REQUIRE(plane);
    const Vec3 normal = placed.linear() * Vec3::UnitX();
    CHECK(plane->normal.cross(normal).norm() < 1e-9);
    // Coordinates of 8 m are known to 1e-12 m.
    CHECK(std::abs(plane->height(placed.translation())) < 1e-8);
}

TEST_CASE("what is off its mirror image by more than allowed has no plane", "[layout]") {
    geom::TriangleMesh mesh = house();
    // Both ends of one edge: the plane across them stays one.
    for (const Eigen::Index i : {2, 8}) mesh.points.row(i) += Eigen::RowVector3d(1.0, 0.0, 0.0);
    const Body body(std::move(mesh));
    const auto plane = body.plane(0.1);
    REQUIRE(plane);
    CHECK(std::abs(plane->normal.z()) == Approx(1.0));
}

TEST_CASE("equal moments tell no planes", "[layout]") {
    // A square prism.
    CHECK_FALSE(Body(test::prism({{{0.0, 0.0}, {40.0, 0.0}, {40.0, 40.0}, {0.0, 40.0}},
                                  {{0, 1, 2}, {0, 2, 3}}},
                                 height))
                    .plane(1e-3));
}

TEST_CASE("a half ends in lines of the section", "[layout][oracle]") {
    const HalfHouse sample;
    REQUIRE(sample.half);
    const cage::HalfSurface& half = *sample.half;
    const geom::SurfaceMesh mesh = half.surface_mesh(0.0);
    CHECK(mesh.points.col(0).minCoeff() == 0.0);
    CHECK(area_of(mesh) == Approx(0.5 * area_of(sample.house.mesh)).epsilon(1e-12));
    // The bottom, both gables, and the ridge, which is an edge of the house.
    std::vector<double> lengths;
    const auto& curves = half.features().curves;
    for (int c = 0; c < int(curves.size()); ++c) {
        if (!half.is_section(c)) continue;
        CHECK(curves[std::size_t(c)].kind == geom::FeatureKind::Free);
        CHECK_FALSE(curves[std::size_t(c)].closed);
        lengths.push_back(curves[std::size_t(c)].length);
    }
    std::sort(lengths.begin(), lengths.end());
    REQUIRE(lengths.size() == 4);
    for (std::size_t k = 0; k < 4; ++k) CHECK(lengths[k] == Approx(k < 2 ? height : ridge));
    std::map<int, double> on_mesh;
    for (const geom::FeatureSide& s : mesh.features)
        on_mesh[s.curve] += (mesh.points.row(s.v0) - mesh.points.row(s.v1)).norm();
    for (const auto& [curve, length] : on_mesh)
        if (half.is_section(curve)) CHECK(length == Approx(curves[std::size_t(curve)].length));
}

TEST_CASE("a half answers for the other side with mirror images", "[layout]") {
    const HalfHouse sample;
    const cage::HalfSurface& half = *sample.half;
    for (const Vec3& p : {Vec3(20.0, 70.0, 10.0), Vec3(35.0, 20.0, -3.0)}) {
        const geom::FootPoint here = half.foot_point(p),
                              there = half.foot_point({-p.x(), p.y(), p.z()});
        CHECK((here.point - there.point).norm() < 1e-12);
        CHECK((here.normal - there.normal).norm() < 1e-12);
        CHECK((here.point - sample.house.reference.foot_point(p).point).norm() < 1e-12);
    }
    const int gable = feature_number(half, {0.0, 30.0, 0.0});
    REQUIRE(half.is_section(gable));
    const geom::FeaturePoint on = half.nearest_on_curve(gable, {5.0, 20.0, -1.0});
    CHECK((on.point - Vec3(0.0, 20.0, 0.0)).norm() < 1e-12);
    CHECK(std::abs(on.tangent.y()) == Approx(1.0));
    CHECK((half.point_on_curve(gable, on.arc_length).point - on.point).norm() < 1e-12);
    // Half-way along it, past its end, and only a piece of it.
    CHECK(half.point_on_curve(gable, 0.5 * ridge).point.y() == Approx(0.5 * ridge));
    CHECK(half.point_on_curve(gable, 2.0 * ridge).arc_length == Approx(ridge));
    CHECK(half.nearest_on_curve(gable, {0.0, 20.0, 0.0}, geom::ArcRange{30.0, 50.0}).distance ==
          Approx(on.arc_length < 30.0 ? 10.0 : on.arc_length - 50.0).margin(1e-9));
}

TEST_CASE("nearest points of pieces of a closed section line are on these", "[layout][oracle]") {
    const Body body(test::triangle_sphere(10.0, 24));
    const auto half = cage::HalfSurface::of(body.body, body.reference, {Vec3::UnitX(), 0.0}, poll);
    REQUIRE(half);
    const auto& curves = half->features().curves;
    for (int c = 0; c < int(curves.size()); ++c) {
        if (!half->is_section(c)) continue;
        const double length = curves[std::size_t(c)].length;
        CHECK(curves[std::size_t(c)].closed);
        const Vec3 query(1.0, 12.0, 3.0);
        for (const auto& piece : {geom::ArcRange{0.1 * length, 0.3 * length},
                                  geom::ArcRange{0.9 * length, 1.2 * length}}) {
            const geom::FeaturePoint found = half->nearest_on_curve(c, query, piece);
            double least = base::infinity;
            for (int k = 0; k <= 1000; ++k) {
                const double at = piece.from + k / 1000.0 * (piece.to - piece.from);
                least = std::min(least, (half->point_on_curve(c, at).point - query).norm());
            }
            // Between samples the distance changes by their spacing at most.
            CHECK(found.distance == Approx(least).margin((piece.to - piece.from) / 1000.0));
        }
    }
}

TEST_CASE("blocks and their mirror image are one closed cage with the whole's features",
          "[layout]") {
    const HalfHouse sample;
    cage::BlocksOnCurves made = with_mirror_image(quads_of(*sample.half), *sample.half, 0.1, poll);
    CHECK(made.blocks.points.size() == 12);
    CHECK(made.blocks.faces.size() == 10);
    // The house has 15 edges, two of which have become two each; the ridge is one of them.
    CHECK(made.blocks.creases.size() == 17);
    CHECK(made.curves.size() == 17);
    for (const auto& [edge, curve] : made.curves) {
        const Vec3 middle = 0.5 * (made.blocks.points[std::size_t(edge.first)] +
                                   made.blocks.points[std::size_t(edge.second)]);
        CHECK(sample.house.reference.nearest_on_curve(curve, middle).distance < 1e-9);
    }
    // Smooth creases cross the plane at the bottom.
    std::sort(made.blocks.corners.begin(), made.blocks.corners.end());
    CHECK(made.blocks.corners.size() == 10);
    CHECK_FALSE(std::ranges::binary_search(made.blocks.corners, 0));
    CHECK(std::ranges::binary_search(made.blocks.corners, 3));
    mesh::TopologyInput input;
    add_to(input, made.blocks);
    geom::Points points(Eigen::Index(made.blocks.points.size()), 3);
    for (std::size_t i = 0; i < made.blocks.points.size(); ++i)
        points.row(Eigen::Index(i)) = made.blocks.points[i];
    const mesh::Cage cage =
        mesh::build_cage(std::move(input), std::move(points), "house", mesh::Facing::AsGiven).cage;
    CHECK(cage.topology->is_closed());
}

}  // namespace patchwright
