#include "grid/far/shell_energy.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::grid {

namespace {

using Matrix = ShellEnergy::Matrix;
using geom::Vec3;

/// Weight of sizes beside that of shapes.
constexpr double size_weight = 0.05;
/// Wanted between sides: those of corners of the border that have one cell would be straight.
constexpr double widest = 0.75 * M_PI;

/// The energy as a function of n = |J|^2 / 2 and d = det J.
struct Terms {
    double value;
    double by_n, by_d;  ///< derivatives
    double nn, nd, dd;  ///< second ones, as far as they are never negative
};

Terms terms(double n, double det, double e) {
    const double root = std::sqrt(det * det + e * e);
    // The same without cancellation where the determinant is negative.
    const double chi = det > 0.0 ? 0.5 * (det + root) : 0.5 * e * e / (root - det);
    const double by_chi = 1.0 / root;  // d(log chi) / d(det)
    const double third = 1.0 / std::cbrt(chi);
    const double p = 2.0 / 3.0 * (1.0 - size_weight) * third * third;
    const double size = 0.5 * size_weight * (1.0 + det * det) / chi;
    const double size_slope = size_weight * det / chi;
    Terms t{n * p + size,
            p,
            -2.0 / 3.0 * n * p * by_chi + size_slope - size * by_chi,
            0.0,
            -2.0 / 3.0 * p * by_chi,
            10.0 / 9.0 * n * p * by_chi * by_chi + size_weight / chi - 2.0 * size_slope * by_chi +
                2.0 * size * by_chi * by_chi};
    // Its square: the worst cells count more.
    t.nn = 2.0 * (t.value * t.nn + t.by_n * t.by_n);
    t.nd = 2.0 * (t.value * t.nd + t.by_n * t.by_d);
    t.dd = 2.0 * (t.value * t.dd + t.by_d * t.by_d);
    t.by_n *= 2.0 * t.value;
    t.by_d *= 2.0 * t.value;
    t.value *= t.value;
    return t;
}

// Inlined by force, as jacobian() and times_weights(): calls for every corner of every cell cost
// about a tenth of the time of a far field.
[[gnu::always_inline]] inline Matrix cofactors(const Matrix& j) {
    Matrix c;
    c.col(0) = j.col(1).cross(j.col(2));
    c.col(1) = j.col(2).cross(j.col(0));
    c.col(2) = j.col(0).cross(j.col(1));
    return c;
}

}  // namespace

/// The corner of one cell: its point, those beside it and the one above or below.
struct ShellEnergy::Corner {
    std::size_t number;                 ///< of all, to keep something for each
    std::array<std::size_t, 4> points;  ///< at the corner, next, previous, along the radial line
    double along;                       ///< 1 where the cell stands on the front, else -1
    /// Of the inverse of the sides wanted, as columns, what is not zero: its first row has two.
    double first, mixed, second, radial;

    /// How J changes with a point: by that times the transpose of one of these.
    [[nodiscard]] std::array<Vec3, 4> weights() const {
        const Vec3 a(first, mixed, 0.0), b(0.0, second, 0.0), c(0.0, 0.0, along * radial);
        return {-a - b - c, a, b, c};
    }
    /// That matrix times all of them.
    [[nodiscard, gnu::always_inline]] std::array<Vec3, 4> times_weights(const Matrix& m) const {
        const Vec3 a = first * m.col(0) + mixed * m.col(1), b = second * m.col(1),
                   c = along * radial * m.col(2);
        return {-a - b - c, a, b, c};
    }
};

ShellEnergy::ShellEnergy(const Shell& shell) : shell_(shell), angles_(shell.mesh.size()) {
    for (std::size_t p = 0; p < shell.mesh.size(); ++p) {
        const auto corners = shell.mesh.corners(p);
        // Around a point of the border the corners do not come back to where they began.
        std::ptrdiff_t ends = 0;
        for (const FrontMesh::Corner& c : corners) {
            ends += std::none_of(corners.begin(), corners.end(),
                                 [&](const FrontMesh::Corner& d) { return d.previous == c.next; });
        }
        const double angle = (ends == 0 ? 2.0 : 1.0) * M_PI / double(corners.size());
        angles_[p] = {std::cos(std::min(angle, widest)), std::sin(std::min(angle, widest))};
    }
}

template <class Visit>
void ShellEnergy::for_corners(int front, const Visit& visit) const {
    const std::size_t size = shell_.mesh.size(), at = std::size_t(front) * size;
    for (std::size_t p = 0; p < size; ++p) {
        const double share = shell_.shares[at + p];
        const auto [cosine, sine] = angles_[p];
        std::size_t number = shell_.mesh.first_corner(p);
        for (const FrontMesh::Corner& c : shell_.mesh.corners(p)) {
            const auto& sides = shell_.sides[number];
            const double outer = share * shell_.outer_side_mm;
            const double first = (1.0 - share) * sides[0] + outer;
            const double second = (1.0 - share) * sides[1] + outer;
            Corner corner;
            corner.first = 1.0 / first;
            corner.mixed = -cosine / (first * sine);
            corner.second = 1.0 / (second * sine);
            for (const int up : {1, 0}) {
                if (front + up == 0 || front + up == shell_.fronts) continue;
                const std::size_t other = up == 1 ? at + size + p : at - size + p;
                corner.points = {at + p, at + std::size_t(c.next), at + std::size_t(c.previous),
                                 other};
                corner.along = up == 1 ? 1.0 : -1.0;
                corner.number = 2 * (std::size_t(front) * shell_.mesh.corner_count() + number) +
                                std::size_t(up);
                corner.radial = 1.0 / shell_.heights_mm[std::min(at + p, other)];
                visit(corner);
            }
            ++number;
        }
    }
}

/// Corners of a front change points of the fronts beside it: every third one at a time.
template <class Visit>
void ShellEnergy::for_fronts(const Visit& visit) const {
    for (int first = 0; first < 3; ++first) {
        const std::size_t count = std::size_t(std::max(0, (shell_.fronts - first + 2) / 3));
        base::parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) visit(first + 3 * int(n));
        });
    }
}

namespace {

template <class Corner>
[[gnu::always_inline]] inline Matrix jacobian(const geom::Points& points, const Corner& corner) {
    const auto at = [&](std::size_t k) -> Vec3 {
        return points.row(Eigen::Index(corner.points[k])).transpose();
    };
    const Vec3 here = at(0);
    const Vec3 next = at(1) - here;
    Matrix j;
    j.col(0) = corner.first * next;
    j.col(1) = corner.mixed * next + corner.second * (at(2) - here);
    j.col(2) = corner.along * corner.radial * (at(3) - here);
    return j;
}

}  // namespace

double ShellEnergy::value(const geom::Points& points, double e) const {
    std::vector<double> sums(std::size_t(shell_.fronts), 0.0);
    for_fronts([&](int front) {
        double sum = 0.0;
        for_corners(front, [&](const Corner& corner) {
            const Matrix j = jacobian(points, corner);
            sum += terms(0.5 * j.squaredNorm(), j.determinant(), e).value;
        });
        sums[std::size_t(front)] = sum;
    });
    double sum = 0.0;
    for (const double s : sums) sum += s;
    return sum;
}

double ShellEnergy::least_determinant(const geom::Points& points) const {
    std::vector<double> least(std::size_t(shell_.fronts), 1.0);
    for_fronts([&](int front) {
        for_corners(front, [&](const Corner& corner) {
            double& here = least[std::size_t(front)];
            here = std::min(here, jacobian(points, corner).determinant());
        });
    });
    return *std::min_element(least.begin(), least.end());
}

void ShellEnergy::derivatives(const geom::Points& points, double e, Derivatives& result) const {
    result.first.setZero(Eigen::Index(shell_.count()), 3);
    result.own.assign(shell_.count(), Matrix::Zero());
    result.above.assign(shell_.count(), Matrix::Zero());
    result.second.resize(2 * std::size_t(shell_.fronts) * shell_.mesh.corner_count());
    for_fronts([&](int front) {
        for_corners(front, [&](const Corner& corner) {
            const Matrix j = jacobian(points, corner);
            const Matrix c = cofactors(j);
            const Terms t = terms(0.5 * j.squaredNorm(), j.col(0).dot(c.col(0)), e);
            const std::array<Vec3, 4> weights = corner.weights();
            result.second[corner.number] = {float(t.by_n), float(t.nn), float(t.nd), float(t.dd)};
            const std::array<Vec3, 4> jw = corner.times_weights(j), cw = corner.times_weights(c);
            for (std::size_t n = 0; n < 4; ++n) {
                result.first.row(Eigen::Index(corner.points[n])) +=
                    (t.by_n * jw[n] + t.by_d * cw[n]).transpose();
            }
            const auto between = [&](std::size_t a, std::size_t b) -> Matrix {
                return t.by_n * weights[a].dot(weights[b]) * Matrix::Identity() +
                       t.nn * jw[a] * jw[b].transpose() +
                       t.nd * (jw[a] * cw[b].transpose() + cw[a] * jw[b].transpose()) +
                       t.dd * cw[a] * cw[b].transpose();
            };
            for (std::size_t n = 0; n < 4; ++n) result.own[corner.points[n]] += between(n, n);
            if (corner.along > 0.0)
                result.above[corner.points[0]] += between(0, 3);
            else
                result.above[corner.points[3]] += between(3, 0);
        });
    });
}

void ShellEnergy::apply(const geom::Points& points, const Derivatives& derivatives,
                        const geom::Points& direction, geom::Points& result) const {
    result.setZero(Eigen::Index(shell_.count()), 3);
    for_fronts([&](int front) {
        for_corners(front, [&](const Corner& corner) {
            const Matrix j = jacobian(points, corner);
            const Matrix c = cofactors(j);
            const auto [by_n, nn, nd, dd] = derivatives.second[corner.number];
            const Matrix dj = jacobian(direction, corner);
            const double along_j = j.cwiseProduct(dj).sum(), along_c = c.cwiseProduct(dj).sum();
            const Matrix change = double(by_n) * dj + (nn * along_j + nd * along_c) * j +
                                  (nd * along_j + dd * along_c) * c;
            const std::array<Vec3, 4> changes = corner.times_weights(change);
            for (std::size_t n = 0; n < 4; ++n)
                result.row(Eigen::Index(corner.points[n])) += changes[n].transpose();
        });
    });
}

}  // namespace patchwright::grid
