// How far the cells of a volume grid are from the shapes that are wanted.
#pragma once

#include "grid/front.h"

namespace patchwright::grid {

/// A grid of fronts over one surface mesh: point p of front k is row k * mesh.size() + p.
struct Shell {
    const FrontMesh& mesh;
    int fronts = 0;
    /// Lengths wanted of each corner's two sides on the first front, to the next point and to the
    /// previous one; corners in the order of the mesh.
    std::vector<std::array<double, 2>> sides;
    double outer_side_mm = 0.0;      ///< wanted of all sides on the last front
    std::vector<double> shares;      ///< of the way from the first front to the last; per point
    std::vector<double> heights_mm;  ///< of the cells above a point; per point but the last front's

    [[nodiscard]] std::size_t count() const { return std::size_t(fronts) * mesh.size(); }
};

/// At each corner of each cell J is the matrix that takes the sides wanted to those there are, and
/// the energy the square of (1 - w) |J|^2 / 3 det^(2/3) + w (1 + det^2) / 2 det: 1 where J is a
/// rotation. For the determinants below fractions stands (det + sqrt(det^2 + e^2)) / 2, which is
/// positive where a cell is folded too. Source: Garanzha et al., Foldover-free maps in 50 lines of
/// code (2021).
class ShellEnergy {
  public:
    explicit ShellEnergy(const Shell& shell);

    [[nodiscard]] double value(const geom::Points& points, double e) const;
    [[nodiscard]] double least_determinant(const geom::Points& points) const;

    /// Two points of a radial line.
    using Matrix = Eigen::Matrix3d;
    struct Derivatives {
        geom::Points first;
        /// The part of the second ones that is never negative: of a point, and between it (rows)
        /// and the point above (columns).
        std::vector<Matrix> own, above;
        /// The same by corners: by |J|^2 / 2, and the second ones by it and the determinant.
        std::vector<std::array<float, 4>> second;
    };
    void derivatives(const geom::Points& points, double e, Derivatives& result) const;
    /// That part of the second derivatives, times a direction.
    /// @param derivatives  at the points
    void apply(const geom::Points& points, const Derivatives& derivatives,
               const geom::Points& direction, geom::Points& result) const;

  private:
    struct Corner;
    template <class Visit>
    void for_corners(int front, const Visit& visit) const;
    template <class Visit>
    void for_fronts(const Visit& visit) const;

    const Shell& shell_;
    /// Cosine and sine of the angle wanted between the sides of a point's corners.
    std::vector<std::array<double, 2>> angles_;
};

}  // namespace patchwright::grid
