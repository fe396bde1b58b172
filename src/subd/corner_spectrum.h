// What repeated subdivision towards a vertex leaves: limits and tangent planes from the spectrum.
#pragma once

#include <patchwright/subd/stencils.h>

#include <Eigen/Core>

namespace patchwright::subd {

/// The left eigenvector of eigenvalue 1 of a subdivision matrix, scaled to sum 1: the limit's mask.
Eigen::RowVectorXd limit_row(const Stencils& matrix);

/// Masks of a face around one of its vertices, n columns each.
struct CornerProbes {
    /// From the vertex to a point on the side that leaves it along u, and along v.
    Eigen::RowVectorXd u, v;
    /// Derivatives along u and v at some points inside the face, a row each.
    Eigen::MatrixXd du, dv;
};

/// Two masks whose values span the tangent plane at the vertex, seen from one face.
struct TangentRows {
    /// 2 x n; their cross product points to the surface's front. Empty where normals have no limit.
    /// The first is along the side u, the second along the side v, up to positive factors; where
    /// both sides leave on one line, the second is at right angles (as a mask) to the first.
    Eigen::MatrixXd rows;
    double eigenvalue = 0.0;  ///< subdominant: how the side u shrinks a step
};

/// The limit of du x dv under repeated subdivision. Eigenvalues may be defective: the normal then
/// converges like 1 over the number of steps, as at corners of two and more faces, whose plane is
/// that of the two creases.
/// @param matrix  stationary subdivision matrix of the neighbourhood, n x n
/// @param largest eigenvalues above it (and below 1) count as absent: the control points are known
///                to have no part in them
/// Source: leading terms of the Jordan form as in Zorin, Smoothness of stationary subdivision on
/// irregular meshes (2000), 3.2, applied to the 2-form du ^ dv.
TangentRows tangent_rows(const Eigen::MatrixXd& matrix, const CornerProbes& probes,
                         double largest = 1.0);

/// The projection onto all eigenspaces with moduli between `bound` and 1, both exclusive.
Eigen::MatrixXd growing_part(const Eigen::MatrixXd& matrix, double bound);

}  // namespace patchwright::subd
