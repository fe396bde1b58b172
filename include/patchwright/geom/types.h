// Points, point lists and boxes that all rooms share. Lengths are millimetres.
#pragma once

#include <Eigen/Core>
#include <limits>

#pragma GCC visibility push(default)
namespace patchwright::geom {

static_assert(EIGEN_MAX_ALIGN_BYTES == 16,
              "compile with the definitions that patchwright's CMake and pkg-config files give");

using Vec3 = Eigen::Vector3d;

/// Larger numbers, and models smaller than the inverse, are no lengths: areas squared must neither
/// overflow nor vanish in double precision.
inline constexpr double largest_coordinate = 1e70;

/// n x 3, one point a row, rows contiguous.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Axis-aligned box; empty (min > max) until something is added.
struct Box3 {
    Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

    void add(const Vec3& p) {
        min = min.cwiseMin(p);
        max = max.cwiseMax(p);
    }
    void add(const Box3& other) {
        min = min.cwiseMin(other.min);
        max = max.cwiseMax(other.max);
    }
    [[nodiscard]] bool empty() const { return (min.array() > max.array()).any(); }
    [[nodiscard]] Vec3 centre() const { return 0.5 * (min + max); }
    [[nodiscard]] double diagonal() const { return empty() ? 0.0 : (max - min).norm(); }
    /// 0 inside.
    [[nodiscard]] double squared_distance(const Vec3& p) const {
        return (min - p).cwiseMax(p - max).cwiseMax(0.0).squaredNorm();
    }
};

/// @pre  `points` may be empty (gives an empty box)
inline Box3 bounding_box(const Points& points) {
    Box3 box;
    for (Eigen::Index i = 0; i < points.rows(); ++i) box.add(points.row(i).transpose());
    return box;
}

}  // namespace patchwright::geom
#pragma GCC visibility pop
