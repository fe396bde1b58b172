// Wings and the like as cages of rings that only the test knows, and fits of cages to them.
#pragma once

#include "shape.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace patchwright::test {

using Rings = std::vector<std::vector<geom::Vec3>>;

/// Quads between rings that follow each other; columns given are sharp from the rings given on, and
/// one ring may be sharp. Lids, when asked for, are bands of quads across both ends, with sharp
/// rims.
/// @pre with lids the rings have an even number of points, 0 and n - 1 at the trailing edge
inline mesh::Cage ring_cage(const Rings& rings, const std::map<int, int>& sharp_from, bool lids,
                            std::optional<int> sharp_ring = {}) {
    const int n = int(rings[0].size()), count = int(rings.size());
    std::vector<geom::Vec3> points;
    for (const auto& ring : rings) points.insert(points.end(), ring.begin(), ring.end());
    const auto at = [&](int i, int k) { return i * n + (k + n) % n; };
    std::vector<std::vector<int>> faces;
    mesh::TopologyInput tags;
    for (int i = 0; i + 1 < count; ++i) {
        for (int k = 0; k < n; ++k)
            faces.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)});
        for (const auto& [k, from] : sharp_from)
            if (i >= from)
                tags.creases.push_back({at(i, k), at(i + 1, k), mesh::infinite_sharpness});
    }
    for (int k = 0; sharp_ring && k < n; ++k)
        tags.creases.push_back(
            {at(*sharp_ring, k), at(*sharp_ring, k + 1), mesh::infinite_sharpness});
    for (const int ring : {0, count - 1}) {
        if (!lids) break;
        for (int k = 0; k < n / 2 - 1; ++k) {
            std::vector<int> quad{at(ring, k), at(ring, k + 1), at(ring, n - 2 - k),
                                  at(ring, n - 1 - k)};
            if (ring == 0) std::reverse(quad.begin(), quad.end());
            faces.push_back(quad);
        }
        for (int k = 0; k < n; ++k)
            tags.creases.push_back({at(ring, k), at(ring, k + 1), mesh::infinite_sharpness});
    }
    return test::make_cage(points, faces, std::move(tags));
}

/// Control points of a section in its own plane, chord 1 from the nose at 0, trailing edge first,
/// below, then round the nose: 2 * 8 of them, `tail` apart at the trailing edge.
inline std::vector<Eigen::Vector2d> section(double thickness, double tail) {
    constexpr std::array<double, 8> shares{1.0, 0.82, 0.6, 0.38, 0.2, 0.08, 0.02, 0.0};
    std::vector<Eigen::Vector2d> points;
    for (const double x : shares) {
        const double half = 5.0 * thickness *
                            (0.2969 * std::sqrt(x + 0.002) - 0.126 * x - 0.3516 * x * x +
                             0.2843 * x * x * x - 0.1036 * x * x * x * x);
        points.emplace_back(x, -half - 0.5 * tail * x);
    }
    for (int i = 7; i >= 0; --i)
        points.emplace_back(points[std::size_t(i)].cwiseProduct(Eigen::Vector2d(1, -1)));
    return points;
}

/// Tapered, swept and twisted along y; x aft, z up.
inline Rings wing_rings() {
    Rings rings;
    for (int i = 0; i <= 6; ++i) {
        const double t = i / 6.0, chord = 1000.0 - 500.0 * t, twist = -0.06 * t;
        rings.emplace_back();
        for (const Eigen::Vector2d& p : section(0.12, 0.006)) {
            const double x = chord * (p.x() - 0.25), z = chord * p.y();
            rings.back().emplace_back(std::cos(twist) * x + std::sin(twist) * z + 400.0 * t,
                                      3000.0 * t, -std::sin(twist) * x + std::cos(twist) * z);
        }
    }
    return rings;
}

/// Points of the limit surface are within the tolerance of the shape, and the other way round.
inline void check_deviation(const mesh::Cage& cage, const Shape& shape, double tolerance_rel) {
    const double tolerance = tolerance_rel * shape.reference.bounds().diagonal();
    const fit::FitResult fitted =
        fit::fit(cage, shape.reference,
                 {.tolerance_mm = 0.6 * tolerance, .preserve_parametrisation = false});
    CHECK(fitted.within_tolerance);
    const Shape result = shape_of(fitted.cage);
    double worst = 0.0;
    for (const auto& sample : shape.reference.sample(4000))
        worst = std::max(worst, result.reference.foot_point(sample.point).distance);
    CHECK(worst < tolerance);
}

}  // namespace patchwright::test
