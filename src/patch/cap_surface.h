// A cap as one surface that points are projected on.
#pragma once

#include "patch/cap_solver.h"
#include "patch/piece.h"

#include <span>
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
        return tangent({face, u, v}).position;
    }

    /// Whether its parameters turn over somewhere, as where neighbouring faces of a narrow fan
    /// overlap beside their edge.
    /// @param shares  of the cap's size, where to look along both edges of each face
    [[nodiscard]] bool turns_over(std::span<const double> shares) const;

  private:
    struct Tangent {
        Eigen::RowVector3d position, du, dv;
    };
    struct Place {
        int face;
        double u, v;
    };
    [[nodiscard]] Tangent tangent(const Place& at) const;
    static Eigen::Vector2d step_to_foot(const Tangent& at, const Eigen::RowVector3d& point);
    /// Of some places on the ray from the vertex through `guess`.
    [[nodiscard]] Place nearest_on_ray(const Eigen::RowVector3d& point, const Place& guess) const;
    /// Goes as far as the step or the first edge to a neighbour, then from that face's view: only
    /// at the edge are its directions known.
    [[nodiscard]] Place moved(const Place& from, const Eigen::Vector2d& step) const;

    std::vector<std::vector<PolynomialPiece>> pieces_;
    bool closed_;
};

/// Whether a surface faces away from most of itself somewhere.
/// @param grids  a square grid of points per face of a fan, row by row
[[nodiscard]] bool is_folded(const std::vector<geom::Points>& grids);

}  // namespace patchwright::patch
