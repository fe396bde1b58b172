// Grids whose points slide on the surface until cells have good shapes.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/grid/plan.h>

#pragma GCC visibility push(default)
namespace patchwright::grid {

struct SmoothOptions {
    int iterations = 100;  ///< at most, of each level of a cascade from coarse grids to fine ones
    base::Progress progress;
};

/// The plan with points moved on the limit surface, those of block edges and their corners too, so
/// that angles come near right ones, those around a vertex of n cells near 360 / n degrees, and
/// lengths near those that the plan has around there. Points on sharp and semi-sharp edges and on
/// the border stay on these, corners where they are.
///
/// Minimises, over all cells' corners, a measure of the matrix that takes the sides wanted to those
/// there are: its condition number, which has no bound where a cell folds, and a part of its
/// determinant. Source: Knupp, Algebraic mesh quality metrics (2001); at corners that are folded
/// Escobar et al., Simultaneous untangling and smoothing of tetrahedral meshes (2003).
/// @throw InvalidArgument when the plan's points were moved already, UsageError when there is not
///        the memory, Cancelled
Plan smoothed(const Plan& plan, const SmoothOptions& options = {});

}  // namespace patchwright::grid
#pragma GCC visibility pop
