// Bounding volume hierarchy over boxes given as data; what the boxes hold is the caller's business.
#pragma once

#include <patchwright/geom/types.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
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
    /// @pre boxes are not empty boxes, finite and fewer than 2^25; 1 <= leaf_size < 32
    /// @throw InvalidArgument when a precondition fails
    explicit Bvh(const std::vector<Box3>& boxes, int leaf_size = 4);

    [[nodiscard]] bool empty() const { return nodes_.empty(); }
    [[nodiscard]] const Box3& bounds() const { return bounds_; }

    /// Renumbers the items so that those of a leaf, and of neighbouring leaves, follow each other:
    /// data that the visitor needs, once sorted the same way, lie together.
    /// @param alignment  each leaf's first number is a multiple of it
    /// @return the number that each item had, by its new number; -1 for numbers that none has
    std::vector<std::int32_t> sort_items(int alignment = 1);

    /// Visits items near `query`, nearer boxes first: calls `leaf(item, bound)` for items whose
    /// node lies no farther than `bound`. `leaf` returns the bound to go on with (at most the one
    /// it was given; smaller once it has found something nearer, negative to stop). Returns the
    /// last bound.
    template <class Leaf>
    double nearest(const Vec3& query, double bound, Leaf&& leaf) const {
        return nearest_leaves(query, bound, [&](int first, int count, double limit) {
            for (int i = first; i < first + count && !(limit < 0.0); ++i)
                limit = leaf(static_cast<int>(items_[static_cast<std::size_t>(i)]), limit);
            return limit;
        });
    }

    /// The same leaf by leaf, once the items are sorted: calls `visit(first, count, bound)`.
    template <class Visit>
    double nearest_leaves(const Vec3& query, double bound, Visit&& visit) const;

  private:
    static constexpr int width = 4;  // push_children sorts as many
    using Lanes = Eigen::Array<float, width, 1>;
    struct alignas(64) Node {
        std::array<Lanes, 3> low, high;          ///< (box - centre_) * scale_; inside out for none
        std::array<std::uint32_t, width> child;  ///< as `pack` makes them
    };
    static constexpr int count_bits = 5;
    /// Inner child: its node and 0; leaf: its first item and how many it has.
    static constexpr std::uint32_t pack(std::size_t first, std::int32_t count) {
        return static_cast<std::uint32_t>(first) << count_bits | static_cast<std::uint32_t>(count);
    }
    static constexpr std::uint32_t first_of(std::uint32_t child) { return child >> count_bits; }
    static constexpr std::int32_t count_of(std::uint32_t child) {
        return static_cast<std::int32_t>(child & ((1u << count_bits) - 1u));
    }
    // One register each: GCC's and Clang's vectors, which choose lane by lane with ?:.
    using Floats [[gnu::vector_size(16)]] = float;
    using Integers [[gnu::vector_size(16)]] = std::int32_t;
    /// Children that wait: the bits of the squared distance above the child's, read as a positive
    /// double, so that keys sort by distance.
    using Keys [[gnu::vector_size(16)]] = double;
    template <class Vector>
    static Vector load(const void* from) {
        Vector value;
        std::memcpy(&value, from, sizeof value);
        return value;
    }
    template <class Value>
    static Value larger(const Value& a, const Value& b) {
        return a > b ? a : b;
    }
    template <class Value>
    static Value smaller(const Value& a, const Value& b) {
        return a < b ? a : b;
    }
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

template <class Visit>
double Bvh::nearest_leaves(const Vec3& query, double bound, Visit&& visit) const {
    if (empty() || bound < 0.0) return bound;
    // Drawn in to where squares do not overflow, which brings it nearer to every box.
    constexpr float farthest = 1e15f;
    const Eigen::Vector3f q =
        ((query - centre_) * scale_).cast<float>().cwiseMax(-farthest).cwiseMin(farthest);
    std::array<double, (width - 1) * max_depth + width> stack;
    std::size_t top = 0;
    constexpr float least = 1e-30f;  // keeps keys from being denormal
    // Never infinite: that is how far children are that a node does not have.
    const auto squared_limit = [&] {
        const double scaled = scale_ * bound;
        constexpr double longest = std::numeric_limits<float>::max();
        return static_cast<float>(
            std::min(rounding * scaled * scaled + 2.0 * double(least), longest));
    };
    float limit = squared_limit();
    const auto push_children = [&](std::uint32_t number) {
        const Node& node = nodes_[number];
        Floats squared = Floats{} + least;
        for (std::size_t k = 0; k < 3; ++k) {
            const float at = q[static_cast<Eigen::Index>(k)];
            const Floats below = load<Floats>(&node.low[k]) - at;
            const Floats above = at - load<Floats>(&node.high[k]);
            const Floats off = larger(larger(below, above), Floats{});
            squared += off * off;
        }
        // What is too far has key 0, sorts behind the others and then lies above the top. All
        // without branches, as they could not be foreseen.
        const Integers is_near = squared <= limit;
        const auto distance = reinterpret_cast<Integers>(squared) & is_near;
        const auto child = load<Integers>(&node.child) & is_near;
        const auto low =
            reinterpret_cast<Keys>(__builtin_shufflevector(child, distance, 0, 4, 1, 5));
        const auto high =
            reinterpret_cast<Keys>(__builtin_shufflevector(child, distance, 2, 6, 3, 7));
        const Keys more = larger(low, high), less = smaller(low, high);
        const Keys a = __builtin_shufflevector(more, less, 0, 2);
        const Keys b = __builtin_shufflevector(more, less, 1, 3);
        const Keys most = larger(a, b), least_of = smaller(a, b);
        // Nearest last, so that it is taken first.
        stack[top] = most[0];
        stack[top + 1] = larger<double>(most[1], least_of[0]);
        stack[top + 2] = smaller<double>(most[1], least_of[0]);
        stack[top + 3] = least_of[1];
        const Integers halves = is_near + __builtin_shufflevector(is_near, is_near, 2, 3, 0, 1);
        top -= static_cast<std::size_t>(static_cast<std::ptrdiff_t>(halves[0] + halves[1]));
    };
    push_children(0);
    while (top > 0) {
        const auto key = std::bit_cast<std::uint64_t>(stack[--top]);
        if (std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32)) > limit) continue;
        const auto child = static_cast<std::uint32_t>(key);
        const std::uint32_t first = first_of(child);
        const std::int32_t count = count_of(child);
        if (count == 0) {
            push_children(first);
            continue;
        }
        const double next = visit(static_cast<int>(first), static_cast<int>(count), bound);
        if (next < 0.0) return next;
        if (!(next < bound)) continue;
        bound = next;
        limit = squared_limit();
    }
    return bound;
}

}  // namespace patchwright::geom
