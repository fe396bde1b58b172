// Products of a limit operator M that iterative solvers need.
#pragma once

#include <patchwright/subd/limit_operator.h>

namespace patchwright::subd {

/// Refers to the operator. Thread-safe and independent of the number of threads, as it is.
class SolverProducts {
  public:
    using Rows = LimitOperator::Rows;
    /// A few consecutive rows of M x, which it may change before they are multiplied with M^T.
    using RowVisit = std::function<Eigen::Array3d(Eigen::Index first, Rows rows)>;

    explicit SolverProducts(const LimitOperator& m) : m_(m) {}

    /// t = M^T M x in one sweep that stores no limit points; returns the squared norm of each
    /// column of M x.
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t) const;
    /// The same with `visit` called for all rows of M x; returns the sum of what the visits return.
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t,
                                  const RowVisit& visit) const;

    /// Sums of the squares of each column: the diagonal of M^T M, or of M^T W M.
    /// @param weights  W's diagonal, one number a site; empty: ones
    [[nodiscard]] Eigen::VectorXd column_squares(const Eigen::VectorXd& weights = {}) const;

    /// x = (M with each entry squared)^T y, columns() x 3: the diagonals of M^T diag(y_c) M.
    /// @pre y is rows() x 3
    void apply_squares_transposed(const geom::Points& y, geom::Points& x) const;

  private:
    const LimitOperator& m_;
};

}  // namespace patchwright::subd
