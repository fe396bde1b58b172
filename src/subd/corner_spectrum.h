// What repeated subdivision towards a vertex leaves: limits and tangents as eigenvectors.
#pragma once

#include <Eigen/Core>

namespace patchwright::subd {

/// The left eigenvector of eigenvalue 1 of a subdivision matrix, scaled to sum 1: the limit's mask.
Eigen::RowVectorXd limit_row(const Eigen::MatrixXd& matrix);

/// Masks of points of a face minus that of the limit at one of its vertices: n columns each.
struct CornerProbes {
    Eigen::RowVectorXd u, v;  ///< on the sides that leave the vertex along u and along v
    Eigen::MatrixXd inside;   ///< inside the face, some rows in several directions
};

/// Two masks whose values span the tangent plane at the vertex, seen from one face.
struct TangentRows {
    /// 2 x n: along the two sides, up to positive factors. Empty where there is no tangent plane,
    /// as at corners with several faces, or none of first order: the two sides leave on one line,
    /// as in a face that is alone on its side of a crease.
    Eigen::MatrixXd rows;
    double eigenvalue = 0.0;  ///< subdominant: how the direction along u shrinks a step
};

/// @param matrix  stationary subdivision matrix of the neighbourhood, n x n
/// Source: components of the probes in the eigenspaces, largest eigenvalue first (Zorin 2000, 3.2).
TangentRows tangent_rows(const Eigen::MatrixXd& matrix, const CornerProbes& probes);

}  // namespace patchwright::subd
