// Steps of Newton's method for all points of a grid at once.
#pragma once

#include "grid/smooth_cells.h"

#include <Eigen/Sparse>

namespace patchwright::grid {

/// Solves for the step of all points; holds which of them act on each other.
class SmoothStep {
  public:
    /// @param freedom  per point: directions that it can go, 0 to 2; its basis' first columns
    SmoothStep(const SmoothCells& cells, const std::vector<int>& freedom);

    /// The step from `points` on, one row a point; zero where there is none, not finite where
    /// numbers are beyond what floating point holds.
    geom::Points solve(const geom::Points& points, const std::vector<SmoothCells::Basis>& bases);

  private:
    const SmoothCells& cells_;
    std::vector<std::int32_t> unknowns_;  ///< two a point; -1: none
    Eigen::SparseMatrix<double> matrix_;  ///< its lower half
    /// Per cell where the entries of its derivatives' lower half are, column by column; -1:
    /// nowhere.
    std::vector<std::array<std::int32_t, 36>> entries_;
};

}  // namespace patchwright::grid
