// How far the free edges of a shape are from each other.
#pragma once

#include <TopoDS_Shape.hxx>

#include <vector>

namespace patchwright::occ {

/// For each free edge the largest distance of its points to the nearest other free edge, in
/// millimetres, ascending: the gap to be closed there if another face continues beyond it, about
/// half the width of the opening if none does.
std::vector<double> free_edge_gaps(const TopoDS_Shape& shape);

/// Free edges with points farther than `reach_mm` from their middle: others are points at that
/// scale.
int count_free_edges_beyond(const TopoDS_Shape& shape, double reach_mm);

}  // namespace patchwright::occ
