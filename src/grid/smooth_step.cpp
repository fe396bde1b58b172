#include "grid/smooth_step.h"

#include <patchwright/base/parallel.h>

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>

namespace patchwright::grid {

namespace {

constexpr std::size_t derivatives_a_task = 512;
/// Share of the diagonal that is added to it, for points whose cells do not hold them.
constexpr double damping = 1e-3;
// Steps are followed by others: they need no more.
constexpr double step_accuracy = 1e-3;
constexpr int most_solver_steps = 300;

/// Calls visit(entry, row, column) for the lower half of a cell's 8 by 8 entries.
template <class Visit>
void for_lower_half(const Visit& visit) {
    std::size_t entry = 0;
    for (int column = 0; column < 8; ++column)
        for (int row = column; row < 8; ++row) visit(entry++, row, column);
}

}  // namespace

SmoothStep::SmoothStep(const SmoothCells& cells, const std::vector<int>& freedom)
    : cells_(cells), unknowns_(2 * freedom.size(), -1) {
    std::int32_t count = 0;
    for (std::size_t p = 0; p < freedom.size(); ++p)
        for (int k = 0; k < freedom[p]; ++k) unknowns_[2 * p + std::size_t(k)] = count++;
    const auto unknown = [&](std::size_t c, int at) {
        const std::int32_t p = cells.cells()[c].points[std::size_t(at) / 2];
        return unknowns_[2 * std::size_t(p) + std::size_t(at) % 2];
    };
    std::vector<Eigen::Triplet<double>> pattern;
    for (std::size_t c = 0; c < cells.cells().size(); ++c)
        for_lower_half([&](std::size_t, int row, int column) {
            const std::int32_t i = unknown(c, row), j = unknown(c, column);
            if (i >= 0 && j >= 0) pattern.emplace_back(std::max(i, j), std::min(i, j), 0.0);
        });
    matrix_.resize(count, count);
    matrix_.setFromTriplets(pattern.begin(), pattern.end());
    entries_.resize(cells.cells().size());
    for (std::size_t c = 0; c < entries_.size(); ++c)
        for_lower_half([&](std::size_t entry, int row, int column) {
            const std::int32_t i = unknown(c, row), j = unknown(c, column);
            entries_[c][entry] = -1;
            if (i < 0 || j < 0) return;
            const auto* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[std::min(i, j)];
            const auto* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[std::min(i, j) + 1];
            entries_[c][entry] = std::int32_t(std::lower_bound(begin, end, std::max(i, j)) -
                                              matrix_.innerIndexPtr());
        });
}

geom::Points SmoothStep::solve(const geom::Points& points,
                               const std::vector<SmoothCells::Basis>& bases) {
    if (matrix_.cols() == 0) return geom::Points::Zero(points.rows(), 3);
    Eigen::VectorXd down = Eigen::VectorXd::Zero(matrix_.rows());
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
    std::vector<SmoothCells::Derivatives> derivatives(64 * derivatives_a_task);
    const std::size_t count = cells_.cells().size();
    for (std::size_t begin = 0; begin < count; begin += derivatives.size()) {
        const std::size_t some = std::min(derivatives.size(), count - begin);
        base::parallel_for(some, derivatives_a_task, [&](std::size_t first, std::size_t last) {
            for (std::size_t c = first; c < last; ++c)
                derivatives[c] = cells_.derivatives(begin + c, points, bases);
        });
        for (std::size_t c = 0; c < some; ++c) {
            const auto& entries = entries_[begin + c];
            for_lower_half([&](std::size_t entry, int row, int column) {
                if (entries[entry] >= 0)
                    matrix_.valuePtr()[entries[entry]] += derivatives[c].second(row, column);
            });
            for (int k = 0; k < 8; ++k) {
                const std::int32_t p = cells_.cells()[begin + c].points[std::size_t(k) / 2];
                const std::int32_t unknown = unknowns_[2 * std::size_t(p) + std::size_t(k) % 2];
                if (unknown >= 0) down[unknown] -= derivatives[c].first[k];
            }
        }
    }
    for (Eigen::Index k = 0; k < matrix_.cols(); ++k) {
        double& diagonal = matrix_.valuePtr()[matrix_.outerIndexPtr()[k]];
        diagonal = diagonal > 0.0 ? diagonal * (1.0 + damping) : 1.0;
    }
    Eigen::ConjugateGradient<
        Eigen::SparseMatrix<double>, Eigen::Lower,
        Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>>
        solver;
    solver.setTolerance(step_accuracy);
    solver.setMaxIterations(most_solver_steps);
    solver.compute(matrix_);
    geom::Points result = geom::Points::Zero(points.rows(), 3);
    if (solver.info() != Eigen::Success) return result;
    const Eigen::VectorXd step = solver.solve(down);
    for (std::size_t p = 0; p < bases.size(); ++p)
        for (std::size_t k = 0; k < 2; ++k)
            if (const std::int32_t unknown = unknowns_[2 * p + k]; unknown >= 0)
                result.row(Eigen::Index(p)) +=
                    step[unknown] * bases[p].col(Eigen::Index(k)).transpose();
    return result;
}

}  // namespace patchwright::grid
