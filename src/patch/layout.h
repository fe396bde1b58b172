// Which faces form one patch.
#pragma once

#include <patchwright/mesh/topology.h>
#include <patchwright/patch/extract.h>

#include <vector>

namespace patchwright::patch {

/// A rectangle of quads. Sharp edges and irregular corners of faces lie on its border only, the
/// latter at its corners; no edge of its border is used twice.
struct Chart {
    int columns = 0;  ///< faces along u
    int rows = 0;     ///< faces along v
    /// Of the face in column i and row j, entry i * rows + j, the corner at its lowest u and v.
    std::vector<mesh::CornerId> cells;

    [[nodiscard]] mesh::CornerId cell(int i, int j) const {
        return cells[std::size_t(i) * std::size_t(rows) + std::size_t(j)];
    }
    /// The half-edges of side 0 (v = 0), 1 (u end), 2 (v end) or 3 (u = 0), counter-clockwise.
    [[nodiscard]] std::vector<mesh::CornerId> side(const mesh::Topology& t, int side) const;
};

/// Covers a mesh of quads. For Covering::Charts: every edge that leaves an irregular corner of a
/// face is followed straight on. Those that run into each other become borders first, shortest
/// first, unless one before is in their way; the others stop at the first border. Each border that
/// ends on another costs half a chart wherever it ends, so that only the first step decides about
/// the number. Rings are cut, and so are charts that many others end on, so that no patch has more
/// than 64 edges. Charts are in the order of their first face, those cut off last.
/// Source: the motorcycle graph of Eppstein, Goodrich, Kim, Tamstorf, Motorcycle graphs: canonical
/// quad mesh partitioning (2008), with saddle connections first.
std::vector<Chart> cover(const mesh::Topology& t, Covering covering);

/// The rectangles that a set of edges cuts a mesh of quads into, in the order of their first face.
/// @param is_border  one entry an edge
/// @pre the regions between borders are rectangles without an irregular vertex inside
std::vector<Chart> rectangles(const mesh::Topology& t, const std::vector<char>& is_border);

/// The half-edge that goes straight on behind `c`, through four faces or, at a boundary, along it;
/// sharp or not. Not valid() where there is none.
mesh::CornerId straight_on(const mesh::Topology& t, mesh::CornerId c);

}  // namespace patchwright::patch
