// Bounding volume hierarchy over boxes given as data; what the boxes hold is the caller's business.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace patchwright::geom {

/// Tree of boxes in one flat array, four children a node in single precision, rounded outward.
/// Immutable after construction, so queries may run on any
/// number of threads; they allocate nothing and depend on nothing but their arguments.
class Bvh {
  public:
    Bvh() = default;
    /// Splits by the surface area heuristic over bins of the box centres (Wald, On fast
    /// construction of SAH-based bounding volume hierarchies, 2007), by the median where bins
    /// cannot tell apart.
    /// @pre boxes are not empty boxes and finite; leaf_size >= 1
    /// @throw InvalidArgument when a precondition fails
    explicit Bvh(const std::vector<Box3>& boxes, int leaf_size = 4);

    [[nodiscard]] bool empty() const { return nodes_.empty(); }
    [[nodiscard]] const Box3& bounds() const { return bounds_; }

    /// Renumbers the items so that those of a leaf, and of neighbouring leaves, follow each other:
    /// data that the visitor needs, once sorted the same way, lie together.
    /// @return the number that each item had, by its new number
    std::vector<std::int32_t> sort_items();

    /// Visits items near `query`, nearer boxes first: calls `leaf(item, bound)` for items whose
    /// node lies no farther than `bound`. `leaf` returns the bound to go on with (at most the one
    /// it was given; smaller once it has found something nearer, negative to stop). Returns the
    /// last bound.
    template <class Leaf>
    double nearest(const Vec3& query, double bound, Leaf&& leaf) const;

  private:
    static constexpr int width = 4;
    using Lanes = Eigen::Array<float, width, 1>;
    struct alignas(64) Node {
        std::array<Lanes, 3> low, high;         ///< (box - centre_) * scale_
        std::array<std::int32_t, width> first;  ///< inner child: its node; leaf: first item slot
        std::array<std::int32_t, width> count;  ///< 0 for inner children, -1 for none
    };
    struct Entry {
        float squared_distance;
        std::int32_t first, count;
    };
    struct Builder;
    struct BinaryNode;
    static constexpr int max_depth = 96;
    // Single precision knows a squared distance to a few 1e-7 of itself.
    static constexpr double rounding = 1.0 + 1e-5;

    void widen(const std::vector<BinaryNode>& binary);

    std::vector<Node> nodes_;
    std::vector<std::int32_t> items_;
    Box3 bounds_;
    Vec3 centre_ = Vec3::Zero();
    double scale_ = 1.0;  ///< makes the largest extent 1
};

template <class Leaf>
double Bvh::nearest(const Vec3& query, double bound, Leaf&& leaf) const {
    if (empty() || bound < 0.0) return bound;
    const Eigen::Vector3f q = ((query - centre_) * scale_).cast<float>();
    std::array<Entry, (width - 1) * max_depth + 1> stack;
    std::size_t top = 0;
    stack[top++] = {0.0f, 0, 0};
    const auto squared_limit = [&] {
        const double scaled = scale_ * bound;
        return static_cast<float>(rounding * scaled * scaled);
    };
    float limit = squared_limit();
    while (top > 0) {
        const Entry entry = stack[--top];
        if (entry.squared_distance > limit) continue;
        if (entry.count > 0) {
            for (std::int32_t i = entry.first; i < entry.first + entry.count; ++i) {
                bound = leaf(static_cast<int>(items_[static_cast<std::size_t>(i)]), bound);
                if (bound < 0.0) return bound;
            }
            limit = squared_limit();
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(entry.first)];
        Lanes squared = Lanes::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            const float at = q[static_cast<Eigen::Index>(k)];
            const Lanes off = (node.low[k] - at).max(at - node.high[k]).max(0.0f);
            squared += off * off;
        }
        // Nearest last, so that it is taken first.
        const std::size_t begin = top;
        for (int child = 0; child < width; ++child) {
            const float distance = squared[child];
            if (!(distance <= limit) || node.count[std::size_t(child)] < 0) continue;
            std::size_t at = top++;
            for (; at > begin && stack[at - 1].squared_distance < distance; --at)
                stack[at] = stack[at - 1];
            stack[at] = {distance, node.first[static_cast<std::size_t>(child)],
                         node.count[static_cast<std::size_t>(child)]};
        }
    }
    return bound;
}

}  // namespace patchwright::geom
