// Points of blocks by their parameters.
#pragma once

#include <patchwright/grid/layout.h>

#include <algorithm>
#include <array>

namespace patchwright::grid {

/// Indices of the point `n` steps along a side of a block, counter-clockwise.
/// @param size  points of the block along i and j
inline std::array<int, 2> on_side(const std::array<int, 2>& size, int side, int n) {
    switch (side) {
        case 0: return {n, 0};
        case 1: return {size[0] - 1, n};
        case 2: return {size[0] - 1 - n, size[1] - 1};
        default: return {0, size[1] - 1 - n};
    }
}

/// A point in one of a block's cells, from its lowest i and j.
struct CellPoint {
    std::size_t number;  ///< of Block::cells
    mesh::CornerId cell;
    double i, j;
};

/// @param at  in [0, columns] and [0, rows]
inline CellPoint cell_point(const Block& block, const Eigen::Vector2d& at) {
    const int column = std::clamp(int(at.x()), 0, block.columns - 1);
    const int row = std::clamp(int(at.y()), 0, block.rows - 1);
    return {std::size_t(column) * std::size_t(block.rows) + std::size_t(row),
            block.cell(column, row), std::clamp(at.x() - column, 0.0, 1.0),
            std::clamp(at.y() - row, 0.0, 1.0)};
}

/// As a point of its face, seen from the face's first corner.
inline CellPoint cell_point(const mesh::Topology& topology, const subd::Location& at) {
    return {0, topology.corners(at.face)[0], at.u, at.v};
}

}  // namespace patchwright::grid
