#include "geom/sparse_solve.h"

#include <Eigen/SparseLU>

namespace patchwright::geom {

std::optional<Eigen::MatrixXd> solve_sparse(const Eigen::SparseMatrix<double>& matrix,
                                            const Eigen::MatrixXd& right) {
    const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
    if (solver.info() != Eigen::Success) return std::nullopt;
    Eigen::MatrixXd solution = solver.solve(right);
    if (!solution.allFinite()) return std::nullopt;
    return solution;
}

}  // namespace patchwright::geom
