// Better numbers of edges from valid ones.
#pragma once

#include "cage/blocks/divisions.h"
#include "cage/poll.h"

namespace patchwright::cage {

/// Of all arcs division_penalty(); of valence-3 insertions a dozen for the first strip around
/// a corner and half for each further one, times length over width of the block: in a slender block
/// lines around a corner are far from straight across it.
double cost_of_divisions(const QuadLayout& layout, const Divisions& divisions);

/// Changes numbers by one along closed ways through the blocks, up or down, as long as the cost
/// falls. A way that enters a block by an arc leaves it by the side opposite with the same change,
/// by another arc of the same side with the opposite one, or around a corner, where it changes an
/// insertion. Ways are cycles of negative cost (Bellman and Ford); none is left at the end but such
/// as meet an arc or a block twice.
/// Source: Heistermann, Warnett and Bommes, Min-deviation-flow in bi-directed graphs for T-mesh
/// quantization (2023), for the graph.
/// @param valid  as divide_arcs() makes them
Divisions improved_divisions(const QuadLayout& layout, const Divisions& valid, Poll& poll);

}  // namespace patchwright::cage
