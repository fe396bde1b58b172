// Four-sided blocks whose sides consist of arcs; blocks may meet with a corner in a side.
#pragma once

#include "cage/blocks/flat_piece.h"
#include "cage/blocks/layout_refused.h"

#include <patchwright/geom/types.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

struct LayoutNode {
    geom::Vec3 point = geom::Vec3::Zero();
    bool held = true;     ///< on a feature; others may move within the surface
    int curve = -1;       ///< the only feature it lies on, along which it may move; -1: none
    bool corner = false;  ///< where features meet at an angle
};

/// Between two nodes, which may be the same one.
struct LayoutArc {
    int start = -1, end = -1;
    std::vector<geom::Vec3> points;  ///< on the model, from start to end, both included
    int curve = -1;                  ///< feature that it lies on; -1: none
    bool crease = false;
    double wanted = 1.0;  ///< edges that it should get
    /// Of its points: where edges that are as long as wanted make it, 0 at its start, 1 at its end;
    /// none where only its number is known.
    std::vector<double> shares;
    int least = 1;   ///< edges that it must have
    int piece = -1;  ///< that it crosses as a straight line; -1: it is on borders
    Vec2 from = Vec2::Zero(), to = Vec2::Zero();  ///< of that line
};

struct ArcUse {
    int arc = -1;
    bool reversed = false;
};

using BlockSide = std::vector<ArcUse>;

struct LayoutBlock {
    std::array<BlockSide, 4>
        sides;  ///< counter-clockwise seen from outside, each begins at a corner
    int piece = -1;
    /// Of a block that is a whole piece: number of the piece's border point at the first corner.
    std::optional<int> first_point;
    /// On the flat piece: where each arc of each side begins; arcs are straight there.
    std::array<std::vector<Vec2>, 4> flat;
};

struct QuadLayout {
    std::vector<LayoutNode> nodes;
    std::vector<LayoutArc> arcs;
    std::vector<LayoutBlock> blocks;
    std::vector<FlatPiece> pieces;
};

}  // namespace patchwright::cage
