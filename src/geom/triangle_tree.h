// Distances to many triangles: a tree whose leaves are measured at once, in single precision.
#pragma once

#include "geom/bvh.h"

#include <patchwright/geom/types.h>

#include <array>
#include <cstdint>
#include <vector>

namespace patchwright::geom {

/// Immutable after construction, so queries may run on any number of threads.
class TriangleTree {
  public:
    static constexpr int lanes = 4;
    using Corners = std::array<Vec3, 3>;

    /// What a leaf's triangles are to a query. Lengths; off by `slack` of the distance at most.
    struct Near {
        alignas(16) std::array<float, lanes> distance;  ///< to the triangle
        alignas(16) std::array<float, lanes> height;    ///< over its plane; negative below, by the
                                                        ///< right-hand rule
        alignas(16) std::array<float, lanes> aside;     ///< in its plane; 0 over the triangle
    };

    TriangleTree() = default;
    /// @param reach  a triangle's box is grown by this much; one a triangle, at least 0
    /// @throw InvalidArgument when a corner or a reach is not finite, or their numbers differ
    TriangleTree(const std::vector<Corners>& triangles, const std::vector<double>& reach);

    [[nodiscard]] bool empty() const { return blocks_.empty(); }
    /// Leaves begin at multiples of `lanes`. The triangle's number by slot; -1 where there is none.
    [[nodiscard]] const std::vector<std::int32_t>& numbers() const { return numbers_; }
    /// How far off, at most, a distance of this size may be: single precision knows places to 1e-7
    /// of the model's extent, or of the way to it where that is longer.
    [[nodiscard]] double slack(double distance) const { return slack_rel * (extent_ + distance); }
    static constexpr double slack_rel = 1e-6;

    /// A point of a triangle near `query`, and the nearest one where the query is over the
    /// triangle: barycentric weights, each within [0, 1].
    [[nodiscard]] Vec3 weights_near(int slot, const Vec3& query) const;

    /// Visits leaves near `query`, nearer ones first: calls `visit(slot, count, near, bound)` with
    /// the leaf's first slot and how many it has, where its box lies no farther than `bound`.
    /// `visit` returns the bound to go on with (at most the one it was given; negative to stop).
    /// Returns the last bound.
    template <class Visit>
    double nearest(const Vec3& query, double bound, Visit&& visit) const {
        const Eigen::Vector3f scaled = (scale_ * (query - centre_)).cast<float>();
        return tree_.nearest_leaves(query, bound, [&](int first, int count, double limit) {
            Near near;
            measure(blocks_[std::size_t(first) / lanes], scaled, near);
            return visit(first, count, near, limit);
        });
    }

  private:
    using Lanes = std::array<float, lanes>;
    /// Each triangle in a frame of its own: the first corner, the way to the second, the way across
    /// it in the plane. In units of the extent, from its centre.
    struct alignas(64) Block {
        std::array<Lanes, 3> origin, along, across;
        Lanes length;                         ///< first to second corner
        std::array<Lanes, 3> side, far_side;  ///< first to third, second to third: unit, length
    };

    // Four lanes of one register: GCC's and Clang's vectors, which choose lane by lane with ?:.
    using Wide [[gnu::vector_size(4 * lanes)]] = float;

    static Wide load(const std::array<float, lanes>& from) {
        Wide value;
        std::memcpy(&value, from.data(), sizeof value);
        return value;
    }
    static void store(const Wide& value, std::array<float, lanes>& to) {
        std::memcpy(to.data(), &value, sizeof value);
    }
    static Wide min(const Wide& a, const Wide& b) { return a < b ? a : b; }
    static Wide root(const Wide& x) {
        using Packet = Eigen::Array<float, lanes, 1>;
        Packet value;
        std::memcpy(value.data(), &x, sizeof x);
        value = value.sqrt();
        Wide result;
        std::memcpy(&result, value.data(), sizeof x);
        return result;
    }
    static Wide clamp(const Wide& x, const Wide& high) {
        const Wide zero{};
        const Wide low = x > zero ? x : zero;
        return min(low, high);
    }

    // Only what lies inside by more than rounding counts as inside: beside the edges the distance
    // to the nearest edge is as good, and never too small.
    static constexpr float inside_margin = 5e-7f;

    // Here, so that it becomes part of what searches and is compiled for the same processor.
    [[gnu::always_inline]] void measure(const Block& block, const Eigen::Vector3f& query,
                                        Near& near) const;

    Bvh tree_;
    std::vector<Block> blocks_;
    std::vector<std::int32_t> numbers_;
    Vec3 centre_ = Vec3::Zero();
    double extent_ = 1.0, scale_ = 1.0;  ///< the longest side of the bounds, unless 0; its inverse
};

inline void TriangleTree::measure(const Block& block, const Eigen::Vector3f& query,
                                  Near& near) const {
    const auto three = [](const std::array<Lanes, 3>& from) {
        return std::array<Wide, 3>{load(from[0]), load(from[1]), load(from[2])};
    };
    const auto origin = three(block.origin), a = three(block.along), c = three(block.across);
    const Wide rx = query[0] - origin[0], ry = query[1] - origin[1], rz = query[2] - origin[2];
    const Wide x = rx * a[0] + ry * a[1] + rz * a[2];
    const Wide y = rx * c[0] + ry * c[1] + rz * c[2];
    const Wide z = rx * (a[1] * c[2] - a[2] * c[1]) + ry * (a[2] * c[0] - a[0] * c[2]) +
                   rz * (a[0] * c[1] - a[1] * c[0]);
    // Squared distance to a side, from how far along it and how far to the left a place is.
    const auto to_side = [](const Wide& at, const Wide& left, const Wide& length) {
        const Wide beyond = at - clamp(at, length);
        return left * left + beyond * beyond;
    };
    const Wide length = load(block.length), xb = x - length;
    const auto s = three(block.side), f = three(block.far_side);
    const Wide right = x * s[1] - y * s[0], left = y * f[0] - xb * f[1];
    Wide aside = min(to_side(x, y, length), min(to_side(x * s[0] + y * s[1], right, s[2]),
                                                to_side(xb * f[0] + y * f[1], left, f[2])));
    const Wide zero{};
    aside = min(y, min(right, left)) > inside_margin ? zero : aside;
    const auto unit = static_cast<float>(extent_);
    store(root(aside + z * z) * unit, near.distance);
    store(root(aside) * unit, near.aside);
    store(z * unit, near.height);
}

}  // namespace patchwright::geom
