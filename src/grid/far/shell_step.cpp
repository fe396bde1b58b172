#include "grid/far/shell_step.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace patchwright::grid {

namespace {

using Matrix = ShellEnergy::Matrix;
using geom::Vec3;

constexpr std::size_t points_a_task = 512;
/// Share of the diagonal that is added to it, for directions that no cell holds.
constexpr double damping = 1e-6;
// Steps are followed by others: they need no more.
constexpr double step_accuracy = 0.1;
constexpr int most_solver_steps = 20;

double dot(const geom::Points& a, const geom::Points& b) {
    constexpr std::size_t rows_a_task = 1 << 14;
    const auto count = std::size_t(a.rows());
    std::vector<double> sums((count + rows_a_task - 1) / rows_a_task);
    base::parallel_for(count, rows_a_task, [&](std::size_t first, std::size_t last) {
        const auto begin = Eigen::Index(first), size = Eigen::Index(last - first);
        sums[first / rows_a_task] =
            a.middleRows(begin, size).cwiseProduct(b.middleRows(begin, size)).sum();
    });
    double sum = 0.0;
    for (const double s : sums) sum += s;
    return sum;
}

}  // namespace

Freedom::Freedom(const Shell& shell, const Vec3& centre, double radius_mm)
    : shell_(shell), centre_(centre), radius_mm_(radius_mm) {}

Vec3 Freedom::along(std::size_t row, const Vec3& at, const Vec3& v) const {
    const std::size_t size = shell_.mesh.size();
    if (row < size) return Vec3::Zero();
    const Vec3& plane = shell_.mesh.plane(row % size);
    Vec3 result = v - plane * plane.dot(v);
    if (row >= shell_.count() - size) {
        // The plane goes through the centre.
        const Vec3 out = (at - centre_).normalized();
        result -= out * out.dot(result);
    }
    return result;
}

void Freedom::project(const geom::Points& points, geom::Points& vectors) const {
    base::parallel_for(shell_.count(), points_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) {
            const auto row = Eigen::Index(r);
            vectors.row(row) =
                along(r, points.row(row).transpose(), vectors.row(row).transpose()).transpose();
        }
    });
}

void Freedom::put_back(geom::Points& points) const {
    for (std::size_t r = shell_.count() - shell_.mesh.size(); r < shell_.count(); ++r) {
        const Vec3 out = points.row(Eigen::Index(r)).transpose() - centre_;
        points.row(Eigen::Index(r)) = (centre_ + radius_mm_ * out.normalized()).transpose();
    }
}

void ShellStep::factor(const geom::Points& points) {
    const std::size_t size = shell_.mesh.size(), count = shell_.count();
    inverse_.resize(count);
    base::parallel_for(size, points_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t p = first; p < last; ++p) {
            for (std::size_t r = p; r < count; r += size) {
                const Vec3 at = points.row(Eigen::Index(r)).transpose();
                Matrix free;
                for (int c = 0; c < 3; ++c) free.col(c) = freedom_.along(r, at, Vec3::Unit(c));
                Matrix& own = derivatives_.own[r];
                const double scale = own.trace();
                own = free * own * free + scale * (Matrix::Identity() - free) +
                      damping * scale * Matrix::Identity();
                if (r >= size) {
                    // Between this point and the one below.
                    Matrix& above = derivatives_.above[r - size];
                    above = (above * free).eval();
                    own -= above.transpose() * inverse_[r - size] * above;
                }
                inverse_[r] = own.ldlt().solve(Matrix::Identity());
                derivatives_.above[r] = (free * derivatives_.above[r]).eval();
            }
        }
    });
}

void ShellStep::precondition(const geom::Points& points, const geom::Points& residual,
                             geom::Points& result) const {
    const std::size_t size = shell_.mesh.size(), count = shell_.count();
    result.resize(residual.rows(), 3);
    base::parallel_for(size, points_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t p = first; p < last; ++p) {
            for (std::size_t r = p; r < count; r += size) {
                Vec3 v = residual.row(Eigen::Index(r)).transpose();
                if (r >= size)
                    v -= derivatives_.above[r - size].transpose() *
                         result.row(Eigen::Index(r - size)).transpose();
                result.row(Eigen::Index(r)) = (inverse_[r] * v).transpose();
            }
            for (std::size_t r = count - size + p; r >= size; r -= size) {
                const std::size_t below = r - size;
                result.row(Eigen::Index(below)) -=
                    (inverse_[below] *
                     (derivatives_.above[below] * result.row(Eigen::Index(r)).transpose()))
                        .transpose();
            }
        }
    });
    freedom_.project(points, result);
}

const geom::Points& ShellStep::solve(const geom::Points& points, double e) {
    energy_.derivatives(points, e, derivatives_);
    residual_ = -derivatives_.first;
    freedom_.project(points, residual_);
    factor(points);
    step_.setZero(points.rows(), 3);
    precondition(points, residual_, preconditioned_);
    direction_ = preconditioned_;
    double rho = dot(residual_, preconditioned_);
    const double enough = step_accuracy * step_accuracy * rho;
    for (int k = 0; k < most_solver_steps && rho > enough; ++k) {
        energy_.apply(points, derivatives_, direction_, changed_);
        freedom_.project(points, changed_);
        const double curvature = dot(direction_, changed_);
        if (!(curvature > 0.0)) break;
        step_ += rho / curvature * direction_;
        residual_ -= rho / curvature * changed_;
        precondition(points, residual_, preconditioned_);
        const double next = dot(residual_, preconditioned_);
        direction_ = preconditioned_ + next / rho * direction_;
        rho = next;
    }
    return step_;
}

}  // namespace patchwright::grid
