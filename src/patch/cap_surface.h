// A cap as one surface that points are projected on.
#pragma once

#include "patch/cap_solver.h"
#include "patch/piece.h"

#include <vector>

namespace patchwright::patch {

class CapSurface {
  public:
    /// @param pieces  per face of the fan those of the cap, seen from the corner, in shares of the
    ///                cap's size
    /// @param closed  whether the last face is a neighbour of the first one
    CapSurface(std::vector<std::vector<PolynomialPiece>> pieces, bool closed)
        : pieces_(std::move(pieces)), closed_(closed) {}

    struct CapFoot {
        double distance;
        CapSolver::Target place;
    };

    /// The foot of `point` that iteration from (u, v) of a face leads to, across edges if need be.
    [[nodiscard]] CapFoot foot(const Eigen::RowVector3d& point, int face, double u, double v) const;

    [[nodiscard]] Eigen::RowVector3d position(int face, double u, double v) const {
        return tangent(face, u, v).position;
    }

  private:
    struct Tangent {
        Eigen::RowVector3d position, du, dv;
    };
    [[nodiscard]] Tangent tangent(int face, double u, double v) const;

    std::vector<std::vector<PolynomialPiece>> pieces_;
    bool closed_;
};

}  // namespace patchwright::patch
