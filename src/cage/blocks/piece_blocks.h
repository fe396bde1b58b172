// Blocks that a disc with few corners is parted into.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/cuts.h"

namespace patchwright::cage {

/// A line of arcs, and where each of them begins on the flat piece.
struct FlatSide {
    BlockSide arcs;
    std::vector<Vec2> flat;
    Vec2 end = Vec2::Zero();
};

/// From its end to its beginning.
FlatSide reversed(const FlatSide& side);

/// The border of a piece from stop to stop: its corners, and where templates need points.
struct FlatBorder {
    std::vector<FlatSide> sides;
    std::vector<int> nodes;     ///< of the layout, at the stops
    std::vector<Vec2> polygon;  ///< the stops on the flat piece
};

/// Adds the blocks of the last piece of the layout, with inner nodes and arcs.
/// Stops are: of a block its corners; of polygons corners and middles of sides in turn; of a lens
/// each corner and two splits; of a drop its corner and four splits; of a disc four splits.
void add_piece_blocks(QuadLayout& layout, const geom::ModelSurface& reference, PieceForm form,
                      const FlatBorder& border);

}  // namespace patchwright::cage
