// One step of Newton's method on the points of a volume grid.
#pragma once

#include "grid/far/shell_energy.h"

namespace patchwright::grid {

/// Directions that points can move along.
class Freedom {
  public:
    /// The first front stays, points of planes stay in these, and those of the last front on a
    /// sphere.
    Freedom(const Shell& shell, const geom::Vec3& centre, double radius_mm);

    /// @return  the part of a vector at a point that can be followed
    [[nodiscard]] geom::Vec3 along(std::size_t row, const geom::Vec3& at,
                                   const geom::Vec3& v) const;
    void project(const geom::Points& points, geom::Points& vectors) const;
    /// Back to where points must lie after a step.
    void put_back(geom::Points& points) const;

  private:
    const Shell& shell_;
    geom::Vec3 centre_;
    double radius_mm_;
};

/// Conjugate gradients, each radial line's points together in the preconditioner.
class ShellStep {
  public:
    ShellStep(const Shell& shell, const ShellEnergy& energy, const Freedom& freedom)
        : shell_(shell), energy_(energy), freedom_(freedom) {}

    /// @return  the way that each point should go
    const geom::Points& solve(const geom::Points& points, double e);

  private:
    void factor(const geom::Points& points);
    void precondition(const geom::Points& points, const geom::Points& residual,
                      geom::Points& result) const;

    const Shell& shell_;
    const ShellEnergy& energy_;
    const Freedom& freedom_;
    ShellEnergy::Derivatives derivatives_;
    std::vector<ShellEnergy::Matrix> inverse_;  ///< of the lines' block Cholesky factors
    geom::Points step_, residual_, direction_, changed_, preconditioned_;
};

}  // namespace patchwright::grid
