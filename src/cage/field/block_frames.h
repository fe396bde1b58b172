// How the axes of blocks go on from one block to the next.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"

#include <map>
#include <utility>
#include <vector>

namespace patchwright::cage {

/// An arc on a side of a block, and the edges of the side before it.
struct ArcPlace {
    int block, side, place;
    int before;
    bool reversed;
};

/// An arc and which end of it: 0 the start, 1 the end.
using ArcEnd = std::pair<int, int>;

/// Where a node may go without another number of edges anywhere.
struct NodeFreedom {
    int free = 0;  ///< 0: stays, 1: along a line, 2: in the surface
    /// Quarters by which the frame of an arc that ends there is turned against the node's.
    std::map<ArcEnd, int> turn;
};

/// Turned by quarters, counter-clockwise.
Vec2 turned(const Vec2& v, int quarters);

/// Every block has coordinates from 0 to the numbers of edges of its first and second side, and
/// every arc a frame: along it from its start, and to its left.
class BlockFrames {
  public:
    /// @pre every block is a whole piece, and its opposite sides have equal numbers of edges
    BlockFrames(const QuadLayout& layout, const Divisions& divisions);

    /// Whether an arc is a line of the coordinates: a feature.
    [[nodiscard]] bool rigid(int arc) const { return rigid_[std::size_t(arc)] != 0; }
    [[nodiscard]] const std::vector<ArcPlace>& places(int arc) const {
        return places_[std::size_t(arc)];
    }
    [[nodiscard]] const NodeFreedom& freedom(int node) const { return freedom_[std::size_t(node)]; }
    /// Quarters by which an arc's frame is turned against the block's axes.
    [[nodiscard]] static int quarters(const ArcPlace& u) { return u.side + (u.reversed ? 2 : 0); }
    /// Where an arc starts, in a block's coordinates.
    [[nodiscard]] Vec2 origin(int arc, const ArcPlace& u) const;

  private:
    void find_places();
    void find_rigid();
    void find_nodes();
    [[nodiscard]] int free_of(int node, const std::vector<ArcPlace>& around);
    [[nodiscard]] ArcPlace previous(const ArcPlace& u) const;
    [[nodiscard]] int arc_of(const ArcPlace& u) const;
    [[nodiscard]] int node_before(const ArcPlace& u) const;

    const QuadLayout& layout_;
    const Divisions& divisions_;
    std::vector<std::vector<ArcPlace>> places_;
    std::vector<char> rigid_;
    std::vector<Vec2> size_;
    std::vector<NodeFreedom> freedom_;
};

}  // namespace patchwright::cage
