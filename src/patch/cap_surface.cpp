#include "patch/cap_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <tuple>

namespace patchwright::patch {

namespace {

/// Values and derivatives of the cubic Bernstein polynomials.
Eigen::Matrix<double, 4, 2> bernstein(double t) {
    const double s = 1.0 - t;
    Eigen::Matrix<double, 4, 2> b;
    b << s * s * s, -3.0 * s * s, 3.0 * t * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * t * s,
        3.0 * t * (2.0 * s - t), t * t * t, 3.0 * t * t;
    return b;
}

}  // namespace

CapSurface::Tangent CapSurface::tangent(int face, double u, double v) const {
    const std::vector<PolynomialPiece>& pieces = pieces_[std::size_t(face)];
    const PolynomialPiece* piece = &pieces.front();
    for (const PolynomialPiece& candidate : pieces) {
        if (candidate.contains(u, v)) piece = &candidate;
    }
    const Eigen::Matrix<double, 4, 2> bu = bernstein((u - piece->u0) / piece->size);
    const Eigen::Matrix<double, 4, 2> bv = bernstein((v - piece->v0) / piece->size);
    Tangent result{Eigen::RowVector3d::Zero(), Eigen::RowVector3d::Zero(),
                   Eigen::RowVector3d::Zero()};
    for (int i = 0; i < 4; ++i) {
        const Eigen::Matrix<double, 2, 3> row =
            bv.transpose() * piece->control.middleRows<4>(4 * i);
        result.position += bu(i, 0) * row.row(0);
        result.du += bu(i, 1) / piece->size * row.row(0);
        result.dv += bu(i, 0) / piece->size * row.row(1);
    }
    return result;
}

CapSurface::CapFoot CapSurface::foot(const Eigen::RowVector3d& point, int face, double u,
                                     double v) const {
    constexpr int most_steps = 12;
    // A step that leaves more than this of the distance is the last one.
    constexpr double no_progress = 0.999;
    const int n = static_cast<int>(pieces_.size());
    CapFoot best{std::numeric_limits<double>::infinity(), {face, u, v, point, {}}};
    for (int step = 0; step < most_steps; ++step) {
        const Tangent at = tangent(face, u, v);
        const Eigen::RowVector3d off = point - at.position;
        const double distance = off.norm();
        const bool progress = distance < no_progress * best.distance;
        if (distance < best.distance) {
            best = {distance, {face, u, v, point, at.du.cross(at.dv).normalized()}};
        }
        if (!progress) break;
        // Gauss-Newton: the nearest point of the tangent plane.
        const double uu = at.du.dot(at.du), uv = at.du.dot(at.dv), vv = at.dv.dot(at.dv);
        const double determinant = uu * vv - uv * uv;
        if (!(determinant > 1e-12 * uu * vv)) break;
        const double along_u = at.du.dot(off), along_v = at.dv.dot(off);
        u += (vv * along_u - uv * along_v) / determinant;
        v += (uu * along_v - uv * along_u) / determinant;
        // Past an edge the neighbour continues, its own edge turned onto this one's.
        if (v < 0.0 && v <= u && (closed_ || face > 0)) {
            face = (face + n - 1) % n;
            std::tie(u, v) = std::pair(-v, u);
        } else if (u < 0.0 && (closed_ || face + 1 < n)) {
            face = (face + 1) % n;
            std::tie(u, v) = std::pair(v, -u);
        }
        u = std::clamp(u, 0.0, 1.0);
        v = std::clamp(v, 0.0, 1.0);
    }
    return best;
}

}  // namespace patchwright::patch
