// Direct solution of sparse systems; in one place, as the solver takes long to compile.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>

namespace patchwright::geom {

/// Of a square matrix that need not be symmetric, by LU factors.
/// @return one column a column of `right`; nothing when the matrix is singular
std::optional<Eigen::MatrixXd> solve_sparse(const Eigen::SparseMatrix<double>& matrix,
                                            const Eigen::MatrixXd& right);

}  // namespace patchwright::geom
