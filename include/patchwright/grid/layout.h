// Which faces of a cage form one structured block, and which sides of blocks meet.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_mask.h>

#include <array>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// What one block covers.
enum class BlockCovering {
    Groups,  ///< as many faces of one group as possible
    Charts,  ///< as many faces as possible, whatever their groups
    Faces    ///< one face
};

/// A curve along which two blocks meet, or one ends. Half-edges follow each other.
struct BlockEdge {
    std::vector<mesh::CornerId> run;
};

/// One use of an edge as (part of) the side of a block.
struct BlockEdgeUse {
    int edge = -1;
    bool reversed = false;  ///< the block's counter-clockwise boundary runs against the edge
};

/// A rectangle of quads: i runs over its columns, j over its rows, outward normals along i x j.
struct Block {
    std::string name;    ///< different for each block
    std::string family;  ///< the groups of its faces, joined by '+'; "surface" where there are none
    int columns = 0, rows = 0;
    /// Of the face in column i and row j, entry i * rows + j, the corner at its lowest i and j.
    std::vector<mesh::CornerId> cells;
    /// Side 0 (j lowest, i rising), 1 (i highest, j rising), 2 (j highest, i falling), 3 (i lowest,
    /// j falling). Opposite sides have equally many edges, which pair up.
    std::array<std::vector<BlockEdgeUse>, 4> sides;

    [[nodiscard]] mesh::CornerId cell(int i, int j) const {
        return cells[std::size_t(i) * std::size_t(rows) + std::size_t(j)];
    }
};

/// Invariants: every edge is used once (there the surface ends) or twice, in opposite directions;
/// so blocks meet one to one.
struct BlockLayout {
    mesh::Cage cage;  ///< quads only: the given one or its first refinement
    std::shared_ptr<const mesh::Topology> given;  ///< of the cage that the layout was made of
    std::vector<BlockEdge> edges;
    std::vector<Block> blocks;
};

/// Covers a cage by blocks. Charts of the patches, which may end in the middle of a neighbour's
/// side, are cut along lines that run on until every side of a block is a whole side of its
/// neighbour.
BlockLayout make_layout(const mesh::Cage& cage, BlockCovering covering = BlockCovering::Groups);

/// The same with blocks `a` and `b` as one, under the name of `a`; `b`'s number goes to the last.
/// @throw InvalidArgument when they do not share a whole side of both
BlockLayout join(const BlockLayout& layout, int a, int b);

/// Joins blocks of one family that share a whole side without creases; longest sides first.
BlockLayout join_all(const BlockLayout& layout);

/// Where an edge lies: use `use` of side `side` of block `block`.
struct EdgePlace {
    int block = -1, side = -1, use = -1;
};

/// The place on a mesh of quads of a point of a cell.
/// @param cell  as in Block::cells
/// @param i,j   from the cell's lowest i and j, 0 to 1
subd::Location place_in_face(const mesh::Topology& topology, mesh::CornerId cell, double i,
                             double j);
/// The same place on the given cage.
subd::Location place_on_given(const BlockLayout& layout, mesh::CornerId cell, double i, double j);

/// Per edge the one or two places where it is used, in the order of blocks.
std::vector<std::vector<EdgePlace>> edge_places(const BlockLayout& layout);

/// Whether the surface has a crease, sharp or semi-sharp, all along the edge; its end is none.
bool is_crease(const BlockLayout& layout, int edge);

}  // namespace patchwright::grid
#pragma GCC visibility pop
