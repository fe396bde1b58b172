// How many edges each arc of a block layout gets.
#pragma once

#include "cage/blocks/block_layout.h"

namespace patchwright::cage {

/// Strips of quads that enter a block by one side and leave by the next: it has a vertex of valence
/// 3 then, from which a line leads to the corner opposite, as many lines beside it as strips turn.
struct Turn {
    int side = 0;  ///< strips turn around the corner at its end
    int count = 0;
};

struct Divisions {
    std::vector<int> edges;   ///< one an arc
    std::vector<Turn> turns;  ///< one a block; count 0: opposite sides have equal numbers
};

/// Numbers of edges, at least what each arc must have and near what it should get. Opposite sides
/// of a block get equal sums but for turns: sides `side` and the next one have `count` more than
/// those opposite. Strips of quads that cross blocks are added one at a time, for arcs that have
/// too few first, then while the sum of (n - wanted)^2 / wanted falls. A strip is the cheapest way
/// through the blocks; it closes or ends at free arcs. A turn costs much and is taken where it must
/// be. Source: strips as in Heistermann, Warnett and Bommes, Min-deviation-flow in bi-directed
/// graphs for T-mesh quantization (2023), who find the best ones.
/// @throw LayoutRefused when no strip can cross an arc
Divisions divide_arcs(const BlockLayout& layout);

}  // namespace patchwright::cage
