// Distances to many triangles: a tree whose leaves are measured at once, in single precision.
#pragma once

#include <patchwright/geom/bvh.h>
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

    void measure(const Block& block, const Eigen::Vector3f& query, Near& near) const;

    Bvh tree_;
    std::vector<Block> blocks_;
    std::vector<std::int32_t> numbers_;
    Vec3 centre_ = Vec3::Zero();
    double extent_ = 1.0, scale_ = 1.0;  ///< the longest side of the bounds, unless 0; its inverse
};

}  // namespace patchwright::geom
