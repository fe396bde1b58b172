#include "geom/triangle_tree.h"

#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

using namespace patchwright;
using geom::TriangleTree;
using geom::Vec3;
using Corners = TriangleTree::Corners;

namespace {

double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const double squared = (b - a).squaredNorm();
    const double s = squared > 0.0 ? std::clamp((p - a).dot(b - a) / squared, 0.0, 1.0) : 0.0;
    return (a + s * (b - a) - p).norm();
}

// In double precision: over the triangle the height, else the nearest side.
double to_triangle(const Vec3& p, const Corners& t) {
    const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double sides =
        std::min({to_segment(p, t[0], t[1]), to_segment(p, t[1], t[2]), to_segment(p, t[2], t[0])});
    // Without area but for rounding: the plane means nothing.
    const double longest = std::max((t[1] - t[0]).squaredNorm(), (t[2] - t[0]).squaredNorm());
    if (normal.norm() <= 1e-12 * longest) return sides;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& a = t[k];
        if ((t[(k + 1) % 3] - a).cross(p - a).dot(normal) < 0.0) return sides;
    }
    return std::abs((p - t[0]).dot(normal.normalized()));
}

struct Found {
    double nearest = 1e300;
    double worst = 0.0;  ///< largest error of a distance, in slacks
};

Found search(const TriangleTree& tree, const std::vector<Corners>& triangles, const Vec3& query) {
    Found found;
    found.nearest = tree.nearest(
        query, 1e300, [&](int slot, int count, const TriangleTree::Near& near, double bound) {
            for (int i = 0; i < count; ++i) {
                const auto number = std::size_t(tree.numbers()[std::size_t(slot + i)]);
                const double distance = double(near.distance[std::size_t(i)]);
                const double truth = to_triangle(query, triangles[number]);
                found.worst = std::max(found.worst, std::abs(distance - truth) / tree.slack(truth));
                bound = std::min(bound, distance + tree.slack(distance));
            }
            return bound;
        });
    return found;
}

std::vector<Corners> random_triangles(int count, double size, double thinness, unsigned seed,
                                      const Vec3& place = Vec3::Zero()) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> spread(-1.0, 1.0);
    const auto vector = [&] { return Vec3(spread(random), spread(random), spread(random)); };
    std::vector<Corners> triangles;
    for (int i = 0; i < count; ++i) {
        const Vec3 a = place + vector(), along = size * vector();
        const Vec3 aside = thinness * size * vector();
        triangles.push_back({a, a + along, a + spread(random) * along + aside});
    }
    return triangles;
}

}  // namespace

TEST_CASE("distances to triangles are those of double precision within the slack",
          "[geom][oracle]") {
    // Needles and triangles that are lines or points among them.
    for (const double thinness : {1.0, 1e-3, 1e-6, 0.0}) {
        for (const double size : {0.1, 1e-4, 0.0}) {
            const auto triangles = random_triangles(700, size, thinness, 5);
            const TriangleTree tree(triangles, std::vector<double>(triangles.size(), 0.0));
            std::mt19937 random(11);
            std::uniform_real_distribution<double> place(-1.5, 1.5);
            for (int i = 0; i < 100; ++i) {
                Vec3 query(place(random), place(random), place(random));
                if (i % 4 == 1) query *= 1e4;                          // far away
                if (i % 4 == 2) query = triangles[std::size_t(i)][1];  // on a corner
                if (i % 4 == 3) {                                      // on a triangle
                    const Corners& t = triangles[std::size_t(i)];
                    query = 0.2 * t[0] + 0.5 * t[1] + 0.3 * t[2];
                }
                double truth = 1e300;
                for (const Corners& t : triangles) truth = std::min(truth, to_triangle(query, t));
                const Found found = search(tree, triangles, query);
                CAPTURE(thinness, size, i);
                CHECK(found.worst <= 1.0);
                CHECK(found.nearest >= truth);
                CHECK(found.nearest <= truth + 3.0 * tree.slack(truth));
            }
        }
    }
}

TEST_CASE("triangles far from the origin are as exact", "[geom][oracle]") {
    const auto triangles = random_triangles(300, 0.1, 1.0, 3, Vec3(1e6, -2e6, 3e6));
    const TriangleTree tree(triangles, std::vector<double>(triangles.size(), 0.0));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Vec3 query = triangles[i][0] + Vec3(0.01, 0.02, -0.03);
        CHECK(search(tree, triangles, query).worst <= 1.0);
    }
}

TEST_CASE("weights lead to the nearest point of a triangle below the query", "[geom][oracle]") {
    const auto triangles = random_triangles(200, 1.0, 1.0, 9);
    const TriangleTree tree(triangles, std::vector<double>(triangles.size(), 0.0));
    for (std::size_t slot = 0; slot < tree.numbers().size(); ++slot) {
        if (tree.numbers()[slot] < 0) continue;
        const Corners& t = triangles[std::size_t(tree.numbers()[slot])];
        const Vec3 inside = 0.3 * t[0] + 0.3 * t[1] + 0.4 * t[2];
        const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
        const Vec3 over = tree.weights_near(int(slot), inside + 0.5 * normal);
        // Weights are as exact as places by the triangle's least height.
        CHECK((over[0] * t[0] + over[1] * t[1] + over[2] * t[2] - inside).norm() < 1e-4);
        const Vec3 beside = tree.weights_near(int(slot), t[0] + 10.0 * (t[1] - t[2]));
        CHECK(beside.minCoeff() >= 0.0);
        CHECK(beside.sum() == Approx(1.0));
    }
}

TEST_CASE("a triangle tree refuses what it cannot search", "[geom]") {
    const auto triangles = random_triangles(2, 1.0, 1.0, 1);
    CHECK_THROWS_AS(TriangleTree(triangles, {0.0}), base::InvalidArgument);
    CHECK_THROWS_AS(TriangleTree(triangles, {0.0, std::nan("")}), base::InvalidArgument);
    CHECK(TriangleTree({}, {}).empty());
}
