// Smooth displacement fields of few unknowns: affine maps and uniform tricubic B-splines.
#pragma once

#include <patchwright/geom/types.h>

#include <Eigen/SparseCore>
#include <array>

namespace patchwright::fit {

/// A basis of scalar fields over a box; three coefficients a function, one for each coordinate,
/// make a displacement.
class DisplacementBasis {
  public:
    /// 1 and the three coordinates, from -1 to 1 along the box's longest side.
    static DisplacementBasis affine(const geom::Box3& box);
    /// Uniform cubic B-splines with about cubic cells: `cells` along the box's longest side, at
    /// least one along the others. Reproduces affine maps.
    /// @pre the box is not empty, cells >= 1
    static DisplacementBasis lattice(const geom::Box3& box, int cells);

    /// Number of functions of such a lattice.
    static int lattice_size(const geom::Box3& box, int cells);

    [[nodiscard]] int size() const { return static_cast<int>(stiffness_.rows()); }

    using Values = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    /// One row a point, one column a function. Beyond the box the outermost cells go on.
    [[nodiscard]] Values values(const geom::Points& points) const;

    /// Quadratic form of the coefficients of one coordinate: of lattices the mean squared second
    /// difference, of affine maps the mean squared change of length; zero for what costs nothing.
    [[nodiscard]] const Eigen::MatrixXd& stiffness() const { return stiffness_; }

  private:
    bool is_affine_ = false;
    geom::Vec3 origin_ = geom::Vec3::Zero();  ///< of affine maps the centre
    geom::Vec3 cell_ = geom::Vec3::Ones();    ///< size of a cell; of affine maps half the side
    std::array<int, 3> cells_{1, 1, 1};
    Eigen::MatrixXd stiffness_;
};

}  // namespace patchwright::fit
