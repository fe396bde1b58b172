#include "geom/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace patchwright::geom {

// Takes seconds to compile: once.
SymmetricEigen symmetric_eigen(const Eigen::Matrix3d& matrix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace patchwright::geom
