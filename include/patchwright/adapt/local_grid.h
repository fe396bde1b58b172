// Surface grids whose cells are divided one by one where that is asked for.
#pragma once

#include <patchwright/adapt/refinement.h>
#include <patchwright/grid/evaluate.h>

#include <array>
#include <cstdint>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::adapt {

/// A quad and the points in the middle of its sides.
struct LocalCell {
    std::array<std::int32_t, 4> corners;  ///< counter-clockwise seen from outside
    /// Of the side from corner k: the hanging node in its middle, -1 where there is none.
    std::array<std::int32_t, 4> hanging{-1, -1, -1, -1};
    std::int32_t block = 0;  ///< of the layout
    std::int32_t level = 0;  ///< times that the plan's cell was divided
};

/// Points are shared: one number each, all over the surface. The polygons of corners and hanging
/// nodes meet edge to edge.
struct LocalGrid {
    geom::Points points;       ///< one row each, on the limit surface
    grid::BlockPlaces places;  ///< of the points, as one block
    std::vector<LocalCell> cells;
    std::vector<std::array<std::int32_t, 2>> free_sides;  ///< where the surface ends
    std::vector<std::string> block_names, block_families;

    [[nodiscard]] int deepest() const;
    [[nodiscard]] std::int64_t hanging_nodes() const;
};

/// Round by round, divides cells 2 x 2 where one of their sides is too long, and others beside
/// these until no side has more than one hanging node (2:1), across blocks too. New points lie in
/// the middle between their neighbours by parameters of the limit surface, each evaluated once.
/// Source: Burstedde, Wilcox and Ghattas, p4est (2011), forests of quadtrees with balanced faces.
/// @throw UsageError when the grid would not fit into memory, Cancelled
LocalGrid refined_locally(const grid::Plan& plan, const Criteria& criteria,
                          const grid::RefineOptions& options = {});

}  // namespace patchwright::adapt
#pragma GCC visibility pop
