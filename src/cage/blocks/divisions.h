// How many edges each arc of a block layout gets.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/poll.h"

#include <optional>

namespace patchwright::cage {

/// A vertex of valence 3 in a block, made by strips of quads that enter the block by one side and
/// leave it by the next. A line leads from the vertex to the corner opposite.
struct Valence3Insertion {
    int side = 0;   ///< strips go around the corner at its end
    int count = 0;  ///< how many strips; 0: no insertion
};

struct Divisions {
    std::vector<int> edges;  ///< one an arc
    std::vector<Valence3Insertion>
        insertions;  ///< one a block; none: opposite sides have equal numbers
};

/// Of all arcs of a side.
inline int edges_of(const BlockSide& side, const Divisions& divisions) {
    int sum = 0;
    for (const ArcUse& use : side) sum += divisions.edges[std::size_t(use.arc)];
    return sum;
}

/// Numbers of edges, at least what each arc must have and near what it should get. Opposite sides
/// of a block get equal sums but for valence-3 insertions: sides `side` and the next one have
/// `count` more than those opposite. Strips of quads that cross blocks are added one at a time, for
/// arcs that have too few first, then while the sum of their costs falls. A strip is
/// the cheapest way through the blocks; it closes or ends at free arcs. A valence-3 insertion costs
/// much and is made where it must be. Source: strips as in Heistermann, Warnett and Bommes,
/// Min-deviation-flow in bi-directed graphs for T-mesh quantization (2023), who find the best ones.
/// @throw LayoutRefused when no strip can cross an arc
/// @param start  valid but for arcs that have less than they must; without one there are no edges
Divisions divide_arcs(const QuadLayout& layout, Poll& poll,
                      std::optional<Divisions> start = std::nullopt);

}  // namespace patchwright::cage
