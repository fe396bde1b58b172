// Bounding volume hierarchy over boxes given as data; what the boxes hold is the caller's business.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace patchwright::geom {

/// Binary tree of boxes in one flat array. Immutable after construction, so queries may run on any
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
    [[nodiscard]] Box3 bounds() const { return empty() ? Box3{} : nodes_.front().box; }

    /// Visits items near `query`, nearer boxes first: calls `leaf(item, bound)` for items whose
    /// node lies no farther than `bound`. `leaf` returns the bound to go on with (at most the one
    /// it was given; smaller once it has found something nearer, negative to stop). Returns the
    /// last bound.
    template <class Leaf>
    double nearest(const Vec3& query, double bound, Leaf&& leaf) const;

  private:
    struct Node {
        Box3 box;
        std::int32_t first =
            0;  ///< inner node: left child, the right one follows; leaf: first item slot
        std::int32_t count = 0;  ///< 0 for inner nodes
    };
    struct Builder;
    static constexpr int max_depth = 96;

    std::vector<Node> nodes_;
    std::vector<std::int32_t> items_;
};

template <class Leaf>
double Bvh::nearest(const Vec3& query, double bound, Leaf&& leaf) const {
    if (empty() || bound < 0.0) return bound;
    std::array<std::pair<double, std::int32_t>, max_depth> stack;
    std::size_t top = 0;
    stack[top++] = {nodes_.front().box.squared_distance(query), 0};
    while (top > 0) {
        const auto [distance, index] = stack[--top];
        if (distance > bound * bound) continue;
        const Node& node = nodes_[static_cast<std::size_t>(index)];
        if (node.count > 0) {
            for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
                bound = leaf(static_cast<int>(items_[static_cast<std::size_t>(i)]), bound);
                if (bound < 0.0) return bound;
            }
            continue;
        }
        const auto child = static_cast<std::size_t>(node.first);
        std::pair<double, std::int32_t> near{nodes_[child].box.squared_distance(query), node.first};
        std::pair<double, std::int32_t> far{nodes_[child + 1].box.squared_distance(query),
                                            node.first + 1};
        if (far.first < near.first) std::swap(near, far);
        stack[top++] = far;
        stack[top++] = near;
    }
    return bound;
}

}  // namespace patchwright::geom
