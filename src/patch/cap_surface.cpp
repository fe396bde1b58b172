#include "patch/cap_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

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

/// The share of a step after which a parameter is 0; infinite where it does not get there.
double share_to_zero(double from, double step) {
    return from + step < 0.0 ? from / -step : std::numeric_limits<double>::infinity();
}

}  // namespace

/// Gauss-Newton: to the nearest point of the tangent plane; none where there is no such plane.
Eigen::Vector2d CapSurface::step_to_foot(const Tangent& at, const Eigen::RowVector3d& point) {
    const Eigen::RowVector3d off = point - at.position;
    const double uu = at.du.dot(at.du), uv = at.du.dot(at.dv), vv = at.dv.dot(at.dv);
    const double determinant = uu * vv - uv * uv;
    constexpr double least_squared_sine = 1e-12;
    if (!(determinant > least_squared_sine * uu * vv)) return Eigen::Vector2d::Zero();
    const double along_u = at.du.dot(off), along_v = at.dv.dot(off);
    return {(vv * along_u - uv * along_v) / determinant,
            (uu * along_v - uv * along_u) / determinant};
}

CapSurface::Tangent CapSurface::tangent(const Place& at) const {
    const auto& [face, u, v] = at;
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

bool CapSurface::turns_over(std::span<const double> shares) const {
    std::vector<Eigen::RowVector3d> normals;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int face = 0; face < static_cast<int>(pieces_.size()); ++face) {
        for (const double u : shares) {
            for (const double v : shares) {
                const Tangent at = tangent({face, u, v});
                normals.push_back(at.du.cross(at.dv));
                sum += normals.back();
            }
        }
    }
    return std::any_of(normals.begin(), normals.end(),
                       [&](const Eigen::RowVector3d& normal) { return !(normal.dot(sum) > 0.0); });
}

CapSurface::Place CapSurface::nearest_on_ray(const Eigen::RowVector3d& point,
                                             const Place& guess) const {
    constexpr int samples = 8;
    Place nearest = guess;
    double least = (point - position(guess.face, guess.u, guess.v)).squaredNorm();
    for (int k = 1; k <= samples; ++k) {
        const double scale = double(k) / (samples * std::max(guess.u, guess.v));
        const double u = scale * guess.u, v = scale * guess.v;
        const double squared = (point - position(guess.face, u, v)).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        nearest = {guess.face, u, v};
    }
    return nearest;
}

CapSurface::Place CapSurface::moved(const Place& from, const Eigen::Vector2d& step) const {
    const int n = static_cast<int>(pieces_.size());
    const double to_u = share_to_zero(from.u, step[0]), to_v = share_to_zero(from.v, step[1]);
    const bool over_first = to_v <= to_u;
    const bool crosses =
        std::min(to_u, to_v) < 1.0 && (closed_ || (over_first ? from.face > 0 : from.face + 1 < n));
    const double share = crosses ? std::min(to_u, to_v) : 1.0;
    const double u = std::clamp(from.u + share * step[0], 0.0, 1.0);
    const double v = std::clamp(from.v + share * step[1], 0.0, 1.0);
    if (!crosses) return {from.face, u, v};
    if (over_first) return {(from.face + n - 1) % n, 0.0, u};
    return {(from.face + 1) % n, v, 0.0};
}

CapSurface::CapFoot CapSurface::foot(const Eigen::RowVector3d& point, int face, double u,
                                     double v) const {
    constexpr int most_steps = 12;
    // Derivatives are short beside a sharp tip, from where steps lead too far.
    constexpr int most_halvings = 8;
    // A step that leaves more than this of the distance is the last one.
    constexpr double no_progress = 0.999;
    Place at = nearest_on_ray(point, {face, u, v});
    Tangent tangent = this->tangent(at);
    double distance = (point - tangent.position).norm();
    CapFoot best{std::numeric_limits<double>::infinity(), {}};
    bool crosses = false;
    for (int step = 0; step < most_steps; ++step) {
        const bool progress = distance < no_progress * best.distance;
        if (distance < best.distance) {
            best = {distance,
                    {at.face, at.u, at.v, point, tangent.du.cross(tangent.dv).normalized()}};
        }
        if (!progress && !crosses) break;
        Eigen::Vector2d way = step_to_foot(tangent, point);
        const double last = distance;
        for (int halving = 0; halving <= most_halvings; ++halving, way *= 0.5) {
            const Place next = moved(at, way);
            crosses = next.face != at.face;
            const Tangent there = this->tangent(next);
            distance = (point - there.position).norm();
            if (!crosses && !(distance < last) && halving < most_halvings) continue;
            at = next;
            tangent = there;
            break;
        }
    }
    return best;
}

bool is_folded(const std::vector<geom::Points>& grids) {
    std::vector<Eigen::RowVector3d> normals;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (const geom::Points& grid : grids) {
        const auto side = static_cast<Eigen::Index>(std::lround(std::sqrt(grid.rows())));
        for (Eigen::Index i = 0; i + 1 < side; ++i) {
            for (Eigen::Index k = i * side; k + 1 < (i + 1) * side; ++k) {
                const Eigen::RowVector3d normal = (grid.row(k + side + 1) - grid.row(k))
                                                      .cross(grid.row(k + 1) - grid.row(k + side));
                normals.push_back(normal);
                sum += normal;
            }
        }
    }
    return std::any_of(normals.begin(), normals.end(),
                       [&](const Eigen::RowVector3d& normal) { return !(normal.dot(sum) > 0.0); });
}

}  // namespace patchwright::patch
