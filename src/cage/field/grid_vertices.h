// Vertices of the quads of a layout in which arcs may have no edges.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"

#include <map>
#include <vector>

namespace patchwright::cage {

/// An arc without edges makes one vertex of its ends, a block without width one line of two sides.
struct GridVertices {
    int count = 0;
    std::vector<int> of_node;
    std::vector<std::vector<int>> of_arc;  ///< from start to end, one more than edges

    /// Along a side, both corners included.
    [[nodiscard]] std::vector<int> along(const BlockSide& side) const;
};
GridVertices grid_vertices(const QuadLayout& layout, const Divisions& divisions);

/// Least numbers of edges with which vertices that must stay apart do: corners, singular nodes and
/// points of different features, the ends of an edge, and closed features with fewer than four
/// edges; insertions have room for their inner lines. Only those that are too small now; none: the
/// divisions can be used. One arc of each way that is too short, the one that wants most edges.
/// @pre every block is a whole piece
std::map<int, int> least_apart(const QuadLayout& layout, const Divisions& divisions);

/// Numbers of edges, improved, with which vertices stay apart that must. LayoutArc::least of arcs
/// that were too short is raised, round by round.
/// @throw LayoutRefused as divide_arcs()
Divisions divisions_apart(QuadLayout& layout, Poll& poll);

}  // namespace patchwright::cage
