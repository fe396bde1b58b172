// Bicubic pieces around an extraordinary vertex whose tangent planes agree exactly.
#pragma once

#include "patch/fan.h"

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace patchwright::patch {

/// Each face of a fan is filled by 2 x 2 bicubic pieces in Bezier form that are C1 with each other:
/// 7 x 7 points (i, j), i along the edge that the face's own corner starts, j along the next one
/// counter-clockwise; (0, 0) is the vertex, rows and columns 4 to 6 follow from what lies outside
/// (position, first and second derivatives at the outer border). Point (i, j) of face s is row
/// 49 s + 7 i + j.
inline constexpr int cap_side = 7;
inline constexpr int cap_points = cap_side * cap_side;

constexpr int cap_row(int face, int i, int j) { return cap_points * face + cap_side * i + j; }

/// Finds the inner points of all faces of a fan. Along a smooth edge, with the curve C of degree 2
/// on the inner half, the derivatives across it sum to 2 cos(phi) (1 - t)^2 C'(t), which is the
/// condition for a common tangent plane; phi is the angle between neighbouring edges at the vertex
/// in an affine image of the fan. Among the solutions it takes the one with the least third
/// derivatives.
/// Source: the condition is that of Peters, Smooth interpolation of a mesh of curves (1991), for
/// the linear alpha of Gregory and Hahn made quadratic so that it joins C1 with the outer half.
class CapSolver {
  public:
    /// @param angle  phi at corners; elsewhere it follows from kind and size
    /// @pre has_tangent_plane(kind), size >= 2 (>= 3 for a ring)
    using Net = Eigen::Matrix<double, Eigen::Dynamic, 3>;

    CapSolver(FanKind kind, int size, double angle = 0.0);
    ~CapSolver();

    /// Between neighbouring edges at the vertex, in an affine image of the fan.
    [[nodiscard]] double angle() const;

    /// @param points  49 size x 3; the vertex, the outer points, and for creases and corners the
    ///                points (1, 0), (2, 0) and (0, 1), (0, 2) on the two sharp edges are read
    [[nodiscard]] Net solve(const Net& points) const;

    /// A point of the limit surface and where the cap is nearest to it.
    struct Target {
        int face;
        double u, v;  ///< shares of the cap's size
        Eigen::RowVector3d point, normal;
    };
    /// As solve(), but the distances of the targets from the tangent planes at their places count
    /// besides the third derivatives.
    /// @param weight  of the derivatives beside the distances
    [[nodiscard]] Net fit(const Net& points, const std::vector<Target>& targets,
                          double weight) const;

  private:
    struct Plan;
    std::unique_ptr<const Plan> plan_;
};

}  // namespace patchwright::patch
