// Coordinates over blocks, and numbers of edges that are improved along ways through them.
#include "cage/field/block_map.h"

#include "cage/field/division_search.h"
#include "cage/remesh/size_field.h"
#include "field_layout.h"
#include "support/triangle_shapes.h"

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright {
namespace {

using cage::Vec2;
using geom::Vec3;

cage::Poll poll;  // never stops

/// Blocks along the lines of a field.
struct Blocks : test::FieldLayout {
    using FieldLayout::FieldLayout;

    void want_edges_of(double length) {
        for (cage::LayoutArc& arc : layout.arcs) {
            arc.wanted = 0.0;
            for (std::size_t i = 0; i + 1 < arc.points.size(); ++i)
                arc.wanted += (arc.points[i + 1] - arc.points[i]).norm() / length;
        }
    }
};

TEST_CASE("coordinates of a box are linear on each side", "[field][oracle]") {
    Blocks box(test::triangle_box(10, 20, 30));
    REQUIRE(box.layout.blocks.size() == 6);
    box.want_edges_of(5.0);
    const auto divisions =
        cage::improved_divisions(box.layout, cage::divide_arcs(box.layout, poll), poll);
    const cage::SizeMetric metric(box.layout, box.reference, {}, poll);
    const cage::BlockMap map(box.layout, divisions, metric, poll);
    for (std::size_t b = 0; b < 6; ++b) {
        const auto& sides = box.layout.blocks[b].sides;
        const int m = cage::edges_of(sides[0], divisions), n = cage::edges_of(sides[1], divisions);
        const Vec3 origin = map.point(int(b), {0.0, 0.0}).point,
                   x = map.point(int(b), {double(m), 0.0}).point - origin,
                   y = map.point(int(b), {0.0, double(n)}).point - origin;
        CHECK(std::abs(x.dot(y)) < 1e-9);
        CHECK(x.norm() == Approx(5.0 * m).epsilon(1e-12));
        CHECK(y.norm() == Approx(5.0 * n).epsilon(1e-12));
        for (const auto& [u, v] : {std::pair{0.3, 0.4}, {0.5, 0.5}, {0.9, 0.1}}) {
            // The linear function is harmonic, and least; weights of obtuse triangles are raised,
            // which moves points by a fraction of a triangle's side of 1.5 mm.
            const Vec3 expected = origin + u * x + v * y;
            CHECK((map.point(int(b), {u * m, v * n}).point - expected).norm() < 0.03);
        }
    }
}

/// A tube along z with the end at z = 0 wider than the other one.
geom::TriangleMesh cone(double wide, double narrow, double height) {
    geom::TriangleMesh mesh = test::triangle_cylinder(1.0, height, 32);
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
        const double radius = wide + (narrow - wide) * mesh.points(i, 2) / height;
        mesh.points(i, 0) *= radius;
        mesh.points(i, 1) *= radius;
    }
    return mesh;
}

TEST_CASE("blocks of a tapered tube keep their four corners and do not fold", "[field][oracle]") {
    // Its side narrows: a border that bends inward is no reason for a cut along it.
    Blocks tube(cone(12.0, 3.0, 30.0));
    tube.want_edges_of(4.0);
    const auto divisions =
        cage::improved_divisions(tube.layout, cage::divide_arcs(tube.layout, poll), poll);
    const cage::SizeMetric metric(tube.layout, tube.reference, {}, poll);
    const cage::BlockMap map(tube.layout, divisions, metric, poll);
    for (std::size_t b = 0; b < tube.layout.blocks.size(); ++b) {
        const auto& sides = tube.layout.blocks[b].sides;
        CHECK(divisions.insertions[b].count == 0);
        CHECK(cage::edges_of(sides[0], divisions) == cage::edges_of(sides[2], divisions));
        CHECK(cage::edges_of(sides[1], divisions) == cage::edges_of(sides[3], divisions));
        for (int i = 0; i < cage::edges_of(sides[0], divisions); ++i) {
            for (int j = 0; j < cage::edges_of(sides[1], divisions); ++j) {
                const auto p = [&](double u, double v) {
                    return map.point(int(b), {i + u, j + v});
                };
                const Vec3 area =
                    (p(1, 1).point - p(0, 0).point).cross(p(0, 1).point - p(1, 0).point);
                CHECK(area.dot(p(0.5, 0.5).normal) > 0.0);
            }
        }
    }
    // Arcs inside the surface are lines of the triangles no more, but points stay on these.
    geom::TriangleMesh triangles;
    std::vector<Vec3> corners;
    for (const cage::FlatPiece& piece : tube.layout.pieces) {
        for (const auto& t : piece.triangles()) {
            const int first = int(corners.size());
            for (const int v : t) corners.push_back(piece.points()[std::size_t(v)]);
            triangles.triangles.push_back({first, first + 1, first + 2});
        }
    }
    triangles.points.resize(Eigen::Index(corners.size()), 3);
    for (std::size_t i = 0; i < corners.size(); ++i)
        triangles.points.row(Eigen::Index(i)) = corners[i].transpose();
    triangles.part.assign(triangles.triangles.size(), -1);
    const geom::MeshReference on_triangles(std::move(triangles));
    for (std::size_t a = 0; a < tube.layout.arcs.size(); ++a) {
        const auto points = map.along(int(a));
        REQUIRE(int(points.size()) == divisions.edges[a] + 1);
        for (const Vec3& p : points) CHECK(on_triangles.foot_point(p).distance < 1e-9);
    }
}

TEST_CASE("edges are as long as the surface bends in each direction", "[field][oracle]") {
    constexpr double radius = 10.0, height = 30.0;
    const Blocks tube(test::triangle_cylinder(radius, height, 64));
    const cage::MetricSizes sizes{.tolerance_rel = 1e-3, .largest_rel = 0.3};
    const cage::SizeMetric metric(tube.layout, tube.reference, sizes, poll);
    const double diagonal = tube.reference.bounds().diagonal();
    const double angle = cage::angle_of_edge(sizes.tolerance_rel, diagonal, 1.0 / radius);
    int looked_at = 0;
    for (std::size_t p = 0; p < tube.layout.pieces.size(); ++p) {
        const cage::FlatPiece& piece = tube.layout.pieces[p];
        for (std::size_t t = 0; t < piece.triangles().size(); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const int v : piece.triangles()[t]) middle += piece.points()[std::size_t(v)] / 3.0;
            // Lids are flat, and curvature of triangles is rough beside the rims.
            if (std::abs(middle.z() - 0.5 * height) > 0.3 * height) continue;
            const Vec3 along(0.0, 0.0, 1.0);
            const Vec3 around = along.cross(middle).normalized();
            const cage::PieceTriangle place{int(p), int(t)};
            // Of the normal curvature, which triangles of 64 sides give to a few percent.
            CHECK(metric.length(place, radius * angle * around) == Approx(1.0).epsilon(0.05));
            CHECK(metric.length(place, sizes.largest_rel * diagonal * along) ==
                  Approx(1.0).epsilon(0.05));
            ++looked_at;
        }
    }
    CHECK(looked_at > 100);
}

TEST_CASE("edges along a rounding are long where triangles are as wide as it is", "[field]") {
    // Sides of 1.6 mm on a radius of 1 mm: planes of triangles are tilted against the surface.
    constexpr double height = 80.0;
    const Blocks rod(test::triangle_cylinder(1.0, height, 64), 0.04);
    const cage::MetricSizes sizes{.tolerance_rel = 1e-3, .largest_rel = 0.3};
    const cage::SizeMetric metric(rod.layout, rod.reference, sizes, poll);
    const double longest = sizes.largest_rel * rod.reference.bounds().diagonal();
    int looked_at = 0;
    for (std::size_t p = 0; p < rod.layout.pieces.size(); ++p) {
        const cage::FlatPiece& piece = rod.layout.pieces[p];
        for (std::size_t t = 0; t < piece.triangles().size(); ++t) {
            double middle = 0.0;
            for (const int v : piece.triangles()[t])
                middle += piece.points()[std::size_t(v)].z() / 3;
            // Edges grow from the lids' rims on.
            if (std::abs(middle - 0.5 * height) > 0.1 * height) continue;
            CHECK(metric.length({int(p), int(t)}, longest * Vec3::UnitZ()) < 2.0);
            ++looked_at;
        }
    }
    CHECK(looked_at > 20);
}

cage::LayoutBlock block(std::array<std::vector<int>, 4> sides) {
    cage::LayoutBlock made;
    for (std::size_t s = 0; s < 4; ++s)
        for (const int arc : sides[s]) made.sides[s].push_back({arc, false});
    return made;
}

TEST_CASE("improved numbers are the best there are", "[layout][oracle]") {
    // 0 on the left is opposite 1 and 2, which go on to 3 and 4; the others are free but for pairs.
    cage::QuadLayout made;
    for (const double wanted : {7.0, 1.0, 3.5, 6.0, 0.5, 2.0, 4.0, 1.0, 9.0, 1.5}) {
        cage::LayoutArc arc;
        arc.wanted = wanted;
        made.arcs.push_back(arc);
    }
    made.blocks = {block({{{5}, {1, 2}, {6}, {0}}}), block({{{7}, {3}, {8}, {1}}}),
                   block({{{8}, {4}, {9}, {2}}})};
    const cage::Divisions start = cage::divide_arcs(made, poll);
    const cage::Divisions better = cage::improved_divisions(made, start, poll);
    const double found = cage::cost_of_divisions(made, better);
    CHECK(found <= cage::cost_of_divisions(made, start));
    // All numbers without an insertion, which costs more than the whole.
    double least = 1e300;
    cage::Divisions all = start;
    for (cage::Valence3Insertion& one : all.insertions) one.count = 0;
    constexpr int most = 10;
    for (int i = 1; i <= most; ++i)
        for (int j = 1; j <= most; ++j)
            for (int k = 1; k <= most; ++k)
                for (int l = 1; l <= most; ++l) {
                    all.edges = {i + j, i, j, i, j, k, k, l, l, l};
                    least = std::min(least, cage::cost_of_divisions(made, all));
                }
    CHECK(found == Approx(least).epsilon(1e-12));
}

TEST_CASE("numbers that must be kept are kept", "[layout]") {
    cage::QuadLayout made;
    for (const double wanted : {1.0, 1.0, 5.0, 5.0}) {
        cage::LayoutArc arc;
        arc.wanted = wanted;
        arc.least = 3;
        made.arcs.push_back(arc);
    }
    made.blocks = {block({{{0}, {2}, {1}, {3}}})};
    const auto better = cage::improved_divisions(made, cage::divide_arcs(made, poll), poll);
    CHECK(better.edges == std::vector<int>{3, 3, 5, 5});
}

}  // namespace
}  // namespace patchwright
