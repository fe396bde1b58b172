// Principal components of the shapes of one cage.
#pragma once

#include <patchwright/mesh/cage.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// Shapes of one topology as their mean and a few displacements. The inner product of two
/// displacements is that of the limit surface's, integrated over the mean surface and divided by
/// its area; modes are orthogonal in it and have length 1. So a weight is the root mean square
/// displacement of the surface, in millimetres, and modes do not depend on where control points are
/// dense.
struct Modes {
    geom::Points mean;                 ///< control points, millimetres
    std::vector<geom::Points> shapes;  ///< displacements of control points for a weight of 1 mm
    Eigen::MatrixXd weights;           ///< of the members: a row each, a column a mode
    /// Standard deviation of each mode's weights, falling.
    std::vector<double> deviations_mm;
    double variance_mm2 = 0.0;  ///< of all displacements from the mean, in all modes there are

    [[nodiscard]] int count() const { return static_cast<int>(shapes.size()); }
    /// Share of the variance that the first `modes` modes hold; 1 where all members are equal.
    [[nodiscard]] double share(int modes) const;
};

/// Control points of mean and modes with these weights.
/// @param weights  millimetres, one a mode
/// @throw InvalidArgument for another number of weights
geom::Points member(const Modes& modes, const Eigen::VectorXd& weights);

/// The `count` modes of largest variance, or as many as there are: one fewer than members at most.
/// The member farthest along a mode has a positive weight.
/// Source: Sirovich, Turbulence and the dynamics of coherent structures (1987), the method of
/// snapshots.
/// @param members  control points, millimetres
/// @throw InvalidArgument for fewer than two members, other numbers of points than the topology's,
///        or fewer modes than one
Modes principal_modes(const std::shared_ptr<const mesh::Topology>& topology,
                      const std::vector<geom::Points>& members, int count);

}  // namespace patchwright::fit
#pragma GCC visibility pop
