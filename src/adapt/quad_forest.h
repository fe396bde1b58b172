// Quads that are divided 2 x 2, with the edges and points that they share.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace patchwright::adapt {

/// Where a point lies: in a block, by its parameters.
struct ForestPlace {
    std::int32_t block = -1;
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
};

/// A forest of quadtrees. Edges, not pairs of points, are what quads share: two edges may join the
/// same points, and a quad may have one edge twice.
class QuadForest {
  public:
    struct Edge {
        std::int32_t a, b;              ///< points
        std::int32_t parent = -1;       ///< edge that this is half of
        std::int32_t child = -1;        ///< first of two: from a to the middle, then on to b
        std::int32_t middle = -1;       ///< point, once it is divided
        std::int32_t users[2]{-1, -1};  ///< leaves
        bool is_border = false;         ///< the surface ends here
    };
    struct Quad {
        /// Side k runs from corner k to the next one, counter-clockwise.
        std::array<std::int32_t, 4> edges;
        std::array<bool, 4> reversed;  ///< the side runs from the edge's b to its a
        std::int32_t block = 0, level = 0;
        std::int32_t child = -1;  ///< first of four, that at corner 0
        /// Of the corners in the block; points on its border have others in others.
        std::array<Eigen::Vector2d, 4> at;
    };

    /// @return its number, as of the other ones
    std::int32_t add_point(const ForestPlace& place);
    std::int32_t add_edge(std::int32_t a, std::int32_t b);
    void add_quad(const Quad& quad);
    /// Once all roots are there.
    void mark_border();

    /// Divides a leaf, and before it those beside it that are larger.
    void divide(std::int32_t quad);

    [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
    [[nodiscard]] const std::vector<Quad>& quads() const { return quads_; }
    [[nodiscard]] const std::vector<ForestPlace>& places() const { return places_; }
    [[nodiscard]] bool is_leaf(std::int32_t quad) const {
        return quads_[std::size_t(quad)].child < 0;
    }
    [[nodiscard]] std::int32_t corner(std::int32_t quad, std::size_t k) const {
        const Quad& q = quads_[std::size_t(quad)];
        const Edge& edge = edges_[std::size_t(q.edges[k])];
        return q.reversed[k] ? edge.b : edge.a;
    }
    /// Halfway along a side.
    [[nodiscard]] ForestPlace middle(std::int32_t quad, std::size_t side) const {
        const Quad& q = quads_[std::size_t(quad)];
        return {q.block, 0.5 * (q.at[side] + q.at[(side + 1) % 4])};
    }

  private:
    void use(std::int32_t edge, std::int32_t quad);
    void leave(std::int32_t edge, std::int32_t quad);
    void divide_edge(std::int32_t edge, const ForestPlace& middle);
    /// The half of a side that begins at its corner, or ends at the next one.
    [[nodiscard]] std::pair<std::int32_t, bool> half(const Quad& quad, std::size_t side,
                                                     bool second) const;

    std::vector<Edge> edges_;
    std::vector<Quad> quads_;
    std::vector<ForestPlace> places_;
};

}  // namespace patchwright::adapt
