// Layouts in which every block has a piece of its own, as coordinates over blocks need them.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/field/cut_disc.h"

#include <array>
#include <vector>

namespace patchwright::cage {

/// Vertices of a block's border by side and arc; each arc's last one is left out.
using BlockLoop = std::array<std::vector<std::vector<int>>, 4>;

/// Makes a block a whole piece, the last one of the layout, laid out as a square.
void set_piece(QuadLayout& layout, LayoutBlock& block, CutDisc& disc, const BlockLoop& loop);

/// Cuts pieces that several blocks share along the arcs between these, and forgets pieces without
/// blocks. Inner nodes move to the triangles.
/// @throw LayoutRefused when lines of a piece are in each other's way
void cut_shared_pieces(QuadLayout& layout);

/// Makes three blocks of each one with a valence-3 insertion, and parts the arcs at which their
/// inner sides end. Afterwards opposite sides of all blocks have equal numbers of edges.
/// @pre every block is a whole piece
/// @throw LayoutRefused as cut_shared_pieces()
void part_at_insertions(QuadLayout& layout, Divisions& divisions);

}  // namespace patchwright::cage
