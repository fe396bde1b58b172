#include "fit/solve/cgls.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace patchwright::fit {

namespace {

using geom::Points;
using Column3 = Eigen::Array3d;

constexpr std::size_t grain = 8192;  // rows a task

/// Calls `body(first, count)` over blocks of rows.
template <class Body>
void over_rows(Eigen::Index rows, const Body& body) {
    base::parallel_for(std::size_t(rows), grain, [&](std::size_t first, std::size_t last) {
        body(Eigen::Index(first), Eigen::Index(last - first));
    });
}

/// Squared norms of the columns, summed block by block in order.
Column3 squared_norms(const Points& p) {
    std::vector<Column3> partial((std::size_t(p.rows()) + grain - 1) / grain);
    over_rows(p.rows(), [&](Eigen::Index first, Eigen::Index count) {
        partial[std::size_t(first) / grain] =
            p.middleRows(first, count).colwise().squaredNorm().transpose().array();
    });
    Column3 sum = Column3::Zero();
    for (const Column3& part : partial) sum += part;
    return sum;
}

/// a / b by column; 0 where b is 0, which stops that column.
Column3 ratio(const Column3& a, const Column3& b) {
    return (b > 0.0).select(a / b.max(1e-300), Column3::Zero());
}

/// x += alpha d and s -= alpha t on `size` numbers, coordinate after coordinate; returns the
/// largest |alpha d|, times `sizes` unless that is null.
double take_step(const Column3& alpha, const double* d, const double* t, const double* sizes,
                 Eigen::Index size, double* x, double* s) {
    using Four = Eigen::Array<double, 12, 1>;  // points
    Four factor;
    factor << alpha, alpha, alpha, alpha;
    Four largest = Four::Zero();
    Eigen::Index i = 0;
    for (; i + 12 <= size; i += 12) {
        const Four step = factor * Eigen::Map<const Four>(d + i);
        Eigen::Map<Four>(x + i) += step;
        Eigen::Map<Four>(s + i) -= factor * Eigen::Map<const Four>(t + i);
        largest =
            largest.max(sizes != nullptr ? (step * Eigen::Map<const Four>(sizes + i)).abs().eval()
                                         : step.abs());
    }
    double result = largest.maxCoeff();
    for (; i < size; ++i) {
        const double step = alpha[i % 3] * d[i];
        x[i] += step;
        s[i] -= alpha[i % 3] * t[i];
        result = std::max(result, std::abs(sizes != nullptr ? step * sizes[i] : step));
    }
    return result;
}

}  // namespace

Eigen::Array3d LinearOperator::normal_product(const Points& x, Points& t) const {
    Points product;
    apply(x, product);
    apply_transposed(product, t);
    return squared_norms(product);
}

Eigen::Array3d LinearOperator::normal_residual(const Points& b, const Points& x, Points& s) const {
    Points r;
    apply(x, r);
    r = b - r;
    apply_transposed(r, s);
    return squared_norms(r);
}

CglsResult solve_cgls(const LinearOperator& a, const Points& b, const Points& start,
                      const CglsOptions& options) {
    if (b.rows() != a.rows() || start.rows() != a.columns()) {
        throw base::InvalidArgument(
            "solve_cgls: sizes of operator, right-hand side and start differ");
    }
    if (options.max_iterations < 0 || !(options.relative_residual >= 0.0) ||
        !(options.step_tolerance >= 0.0)) {
        throw base::InvalidArgument("solve_cgls: iterations and tolerance must not be negative");
    }
    if (options.unknown_sizes != nullptr && options.unknown_sizes->rows() != a.columns()) {
        throw base::InvalidArgument("solve_cgls: unknown_sizes has not one row an unknown");
    }
    const Preconditioner* const b_of = options.preconditioner;
    if (b_of != nullptr && b_of->size() != a.columns()) {
        throw base::InvalidArgument(
            "solve_cgls: preconditioner has another size than the operator");
    }
    const auto steps_of = [&](const Column3& norms) {
        return options.joint ? Column3::Constant(norms.sum()).eval() : norms;
    };
    CglsResult result;
    result.x = start;
    Points s, d, t, u;    // A^T r, direction, A^T A d, B^T s
    Points safe = start;  // where the residual was made from x the last time
    Column3 residual, least_residual = Column3::Constant(std::numeric_limits<double>::infinity());
    const auto set_residual = [&] {
        residual = a.normal_residual(b, result.x, s);
        // Every step makes it smaller but those that rounding alone directs, where A^T r is zero.
        const Column3 now = steps_of(residual);
        if (!(now <= least_residual * (1.0 + 1e-9)).all()) {
            for (int c = 0; c < 3; ++c) {
                if (!(now[c] <= least_residual[c])) result.x.col(c) = safe.col(c);
            }
            residual = a.normal_residual(b, result.x, s);
        }
        least_residual = steps_of(residual);
        safe = result.x;
    };
    const auto preconditioned_norms = [&] {
        return steps_of(b_of != nullptr ? b_of->apply_transposed(s, u) : squared_norms(s));
    };
    const auto steepest = [&] {
        d = s;
        if (b_of != nullptr) b_of->apply(u, Column3::Zero(), d);
    };
    set_residual();
    Column3 gamma = preconditioned_norms();
    // Below rounding the recurrence goes on where the truth cannot follow.
    const double wanted = std::max(options.relative_residual, 1e-15);
    const Column3 goal = gamma * wanted * wanted;
    Column3 least = gamma;  // when the residual was made anew the last time
    steepest();
    bool still = false;
    for (;;) {
        if (still || !(gamma > goal).any()) {
            // What rounding has put between the recurrence and the truth shows here.
            if (result.iterations > 0) set_residual();
            gamma = preconditioned_norms();
            const bool better = (gamma < 0.25 * least || gamma <= goal).all();
            if (still && (gamma > goal).any()) result.stop = CglsStop::StepTolerance;
            if (still || !better || !(gamma > 1.1 * goal).any()) break;
            least = gamma;
            steepest();
        }
        if (result.iterations == options.max_iterations) {
            set_residual();
            result.stop = CglsStop::MaxIterations;
            break;
        }
        base::report_progress(options.progress, "solve",
                              double(result.iterations) / options.max_iterations);
        // Coordinates that are there stay: their directions hold nothing but rounding any more.
        const Eigen::Array<bool, 3, 1> open = gamma > goal;
        const Column3 alpha = open.select(ratio(gamma, steps_of(a.normal_product(d, t))), 0.0);
        const std::size_t blocks = (std::size_t(d.rows()) + grain - 1) / grain;
        std::vector<double> change(blocks, 0.0);
        std::vector<Column3> norms(blocks);
        Column3 next;
        over_rows(d.rows(), [&](Eigen::Index first, Eigen::Index count) {
            const auto block = std::size_t(first) / grain;
            const Eigen::Index at = 3 * first, size = 3 * count;
            const double* sizes =
                options.unknown_sizes != nullptr ? options.unknown_sizes->data() + at : nullptr;
            change[block] = take_step(alpha, d.data() + at, t.data() + at, sizes, size,
                                      result.x.data() + at, s.data() + at);
            if (b_of == nullptr) {
                norms[block] =
                    s.middleRows(first, count).colwise().squaredNorm().transpose().array();
            }
        });
        if (b_of != nullptr) {
            next = steps_of(b_of->apply_transposed(s, u));
        } else {
            Column3 sum = Column3::Zero();
            for (const Column3& part : norms) sum += part;
            next = steps_of(sum);
        }
        const Column3 beta = open.select(ratio(next, gamma), 0.0);
        if (b_of != nullptr) {
            b_of->apply(u, beta, d);
        } else {
            over_rows(d.rows(), [&](Eigen::Index first, Eigen::Index count) {
                auto block = d.middleRows(first, count);
                block = s.middleRows(first, count) + (block * beta.matrix().asDiagonal()).eval();
            });
        }
        gamma = next;
        ++result.iterations;
        still = options.step_tolerance > 0.0 && blocks > 0 &&
                *std::max_element(change.begin(), change.end()) <= options.step_tolerance;
    }
    result.residual = std::sqrt(residual.sum());
    result.normal_residual = s.norm();
    return result;
}

}  // namespace patchwright::fit
