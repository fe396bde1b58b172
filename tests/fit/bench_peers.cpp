#include "fit/bench_peers.h"

#include "support/bench.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_mask.h>

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace patchwright::bench {

using geom::Points;

SparseRows sparse_rows(const mesh::Cage& cage, const subd::ParameterSet& set) {
    const subd::LimitEvaluator evaluator(cage.topology);
    const auto count = Eigen::Index(set.size());
    SparseRows matrix(cage.topology->face_count() * count, cage.topology->vertex_count());
    std::vector<int> row_starts{0};
    std::vector<std::pair<int, double>> row;
    std::vector<int> columns;
    std::vector<double> values;
    for (const mesh::FaceId f : cage.topology->faces()) {
        for (const auto& at : set) {
            const subd::Mask mask = evaluator.mask({f, at.x(), at.y()});
            row.clear();
            for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
                const double w = mask.rows(0, Eigen::Index(k));
                if (w != 0.0) row.emplace_back(mask.vertices[k], w);
            }
            std::sort(row.begin(), row.end());
            for (const auto& [column, w] : row) {
                columns.push_back(column);
                values.push_back(w);
            }
            row_starts.push_back(static_cast<int>(columns.size()));
        }
    }
    matrix.resizeNonZeros(Eigen::Index(columns.size()));
    std::copy(row_starts.begin(), row_starts.end(), matrix.outerIndexPtr());
    std::copy(columns.begin(), columns.end(), matrix.innerIndexPtr());
    std::copy(values.begin(), values.end(), matrix.valuePtr());
    return matrix;
}

namespace {

constexpr std::size_t grain = 8192;

/// One row of a product, three columns: sum of weight * point.
[[gnu::always_inline]] inline void row_product(const SparseRows& m, std::size_t row,
                                               const double* from, double* to) {
    double x = 0.0, y = 0.0, z = 0.0;
    const int* index = m.innerIndexPtr();
    const double* weight = m.valuePtr();
    for (int k = m.outerIndexPtr()[row]; k < m.outerIndexPtr()[row + 1]; ++k) {
        const double* p = from + 3 * std::ptrdiff_t(index[k]);
        x += weight[k] * p[0];
        y += weight[k] * p[1];
        z += weight[k] * p[2];
    }
    to[0] = x;
    to[1] = y;
    to[2] = z;
}

// NOLINTBEGIN: the same loops for any processor and for AVX2, as the operator has them.
#define PATCHWRIGHT_ROWS(name)                                                              \
    void name(const SparseRows& m, std::size_t first, std::size_t last, const double* from, \
              double* to, double* norms) {                                                  \
        for (std::size_t row = first; row < last; ++row) {                                  \
            double* at = to + 3 * std::ptrdiff_t(row);                                      \
            row_product(m, row, from, at);                                                  \
            for (int c = 0; c < 3; ++c) norms[c] += at[c] * at[c];                          \
        }                                                                                   \
    }
PATCHWRIGHT_ROWS(rows_any)
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] PATCHWRIGHT_ROWS(rows_avx2)
#endif
    // NOLINTEND

    void rows(const SparseRows& m, std::size_t first, std::size_t last, const double* from,
              double* to, double* norms) {
#if defined(__x86_64__)
    static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (has) return rows_avx2(m, first, last, from, to, norms);
#endif
    rows_any(m, first, last, from, to, norms);
}

/// to = m * from, the squared norms of its columns, and `also(first, count)` for each block.
template <class Also>
Eigen::Array3d product(const SparseRows& m, const Points& from, Points& to, const Also& also) {
    to.resize(m.rows(), 3);
    std::vector<Eigen::Array3d> partial((std::size_t(m.rows()) + grain - 1) / grain,
                                        Eigen::Array3d::Zero());
    base::parallel_for(std::size_t(m.rows()), grain, [&](std::size_t first, std::size_t last) {
        also(Eigen::Index(first), Eigen::Index(last - first));
        rows(m, first, last, from.data(), to.data(), partial[first / grain].data());
    });
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    for (const auto& part : partial) sum += part;
    return sum;
}

}  // namespace

std::size_t StoredRows::bytes() const {
    return std::size_t(matrix_.nonZeros()) * 2 * (sizeof(double) + sizeof(int)) +
           std::size_t(matrix_.rows() + matrix_.cols()) * sizeof(int);
}

fit::CglsResult StoredRows::solve(const Points& b, const Points& start,
                                  const fit::CglsOptions& options) const {
    const auto nothing = [](Eigen::Index, Eigen::Index) {};
    fit::CglsResult result{.x = start};
    Points q, s, r;
    product(matrix_, start, q, nothing);
    r = b - q;
    Eigen::Array3d gamma = product(transposed_, r, s, nothing);
    Points d = s;
    const Eigen::Array3d goal = gamma * options.relative_residual * options.relative_residual;
    while ((gamma > goal).any() && result.iterations < options.max_iterations) {
        const Eigen::Array3d norms = product(matrix_, d, q, nothing);
        const Eigen::Array3d alpha = (norms > 0.0).select(gamma / norms.max(1e-300), 0.0);
        base::parallel_for(std::size_t(r.rows()), grain, [&](std::size_t first, std::size_t last) {
            const auto at = Eigen::Index(first), count = Eigen::Index(last - first);
            r.middleRows(at, count).noalias() -=
                q.middleRows(at, count) * alpha.matrix().asDiagonal();
        });
        std::vector<double> change((std::size_t(d.rows()) + grain - 1) / grain, 0.0);
        const Eigen::Array3d next =
            product(transposed_, r, s, [&](Eigen::Index at, Eigen::Index count) {
                const auto step = d.middleRows(at, count) * alpha.matrix().asDiagonal();
                result.x.middleRows(at, count).noalias() += step;
                if (options.step_tolerance > 0.0) {
                    change[std::size_t(at) / grain] = Points(step).cwiseAbs().maxCoeff();
                }
            });
        const Eigen::Array3d beta = (gamma > 0.0).select(next / gamma.max(1e-300), 0.0);
        base::parallel_for(std::size_t(d.rows()), grain, [&](std::size_t first, std::size_t last) {
            auto block = d.middleRows(Eigen::Index(first), Eigen::Index(last - first));
            block = s.middleRows(Eigen::Index(first), Eigen::Index(last - first)) +
                    (block * beta.matrix().asDiagonal()).eval();
        });
        gamma = next;
        ++result.iterations;
        if (options.step_tolerance > 0.0 &&
            *std::max_element(change.begin(), change.end()) <= options.step_tolerance) {
            break;
        }
    }
    result.normal_residual = s.norm();
    return result;
}

PeerResult solve_eigen(const SparseRows& matrix, const Points& b, const Points& start,
                       double relative_residual) {
    PeerResult result{.x = Points(start.rows(), 3)};
    Eigen::setNbThreads(base::thread_count());
    result.seconds = test::seconds([&] {
        Eigen::LeastSquaresConjugateGradient<SparseRows> solver;
        solver.setTolerance(relative_residual);
        solver.setMaxIterations(1000);
        solver.compute(matrix);
        for (int c = 0; c < 3; ++c) {
            result.x.col(c) =
                solver.solveWithGuess(Eigen::VectorXd(b.col(c)), Eigen::VectorXd(start.col(c)));
            result.iterations = std::max(result.iterations, static_cast<int>(solver.iterations()));
        }
    });
    return result;
}

}  // namespace patchwright::bench
