// What repeated subdivision towards a vertex leaves: limits and tangents as eigenvectors.
#pragma once

#include <Eigen/Core>

namespace patchwright::subd {

/// The left eigenvector of eigenvalue 1 of a subdivision matrix, scaled to sum 1: the limit's mask.
Eigen::RowVectorXd limit_row(const Eigen::MatrixXd& matrix);

/// Two masks whose values span the tangent plane at the vertex, seen from one face.
struct TangentRows {
    /// 2 x n: along the face's u and v there, up to positive factors; where both edges leave in one
    /// direction to first order, the second row is the next order's, on the same side. Empty: the
    /// surface has no tangent plane from this face.
    Eigen::MatrixXd rows;
    double eigenvalue = 0.0;  ///< subdominant: how the direction along u shrinks a step
};

/// @param matrix   stationary subdivision matrix of the neighbourhood, n x n
/// @param along_u  mask of a point on the face's u side minus that of the limit: 1 x n
/// @param along_v  the same for the v side
/// Source: components of the two in the eigenspaces, largest eigenvalue first (Zorin 2000, 3.2).
TangentRows tangent_rows(const Eigen::MatrixXd& matrix, const Eigen::RowVectorXd& along_u,
                         const Eigen::RowVectorXd& along_v);

}  // namespace patchwright::subd
