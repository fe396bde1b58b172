// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices.
#pragma once

#include <patchwright/geom/types.h>

namespace patchwright::geom {

struct SymmetricEigen {
    Vec3 values;              ///< ascending
    Eigen::Matrix3d vectors;  ///< as columns, orthonormal
};

/// Of the lower triangle.
SymmetricEigen symmetric_eigen(const Eigen::Matrix3d& matrix);

}  // namespace patchwright::geom
