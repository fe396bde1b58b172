#include "fit/solve/cgls.h"

#include "fit/solve/over_rows.h"

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

constexpr std::size_t rows_a_task = 8192;  // rows a task

/// Calls `body(first, count)` over blocks of rows.
/// Squared norms of the columns, summed block by block in order.
Column3 squared_norms(const Points& p) {
    std::vector<Column3> partial((std::size_t(p.rows()) + rows_a_task - 1) / rows_a_task);
    over_rows<rows_a_task>(p.rows(), [&](Eigen::Index first, Eigen::Index count) {
        partial[std::size_t(first) / rows_a_task] =
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

namespace {

void check(const LinearOperator& a, const Points& b, const Points& start,
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
    if (options.preconditioner != nullptr && options.preconditioner->size() != a.columns()) {
        throw base::InvalidArgument(
            "solve_cgls: preconditioner has another size than the operator");
    }
}

/// One solve. s = A^T r follows its recurrence between calls of set_residual(), which compute it
/// from x and so remove the recursive residual drift.
class CglsSolve {
  public:
    CglsSolve(const LinearOperator& a, const Points& b, const Points& start,
              const CglsOptions& options)
        : a_(a), b_(b), options_(options), verified_(start) {
        result_.x = start;
    }

    CglsResult run() && {
        set_residual();
        gamma_ = preconditioned_norms();
        const double wanted = std::max(options_.relative_residual, min_relative_residual);
        goal_ = gamma_ * wanted * wanted;
        Column3 gamma_at_restart = gamma_;
        restart();
        bool still = false;
        for (;;) {
            if (still || !(gamma_ > goal_).any()) {
                if (result_.iterations > 0) set_residual();
                gamma_ = preconditioned_norms();
                const bool better =
                    (gamma_ < restart_gain * gamma_at_restart || gamma_ <= goal_).all();
                if (still && (gamma_ > goal_).any()) result_.stop = CglsStop::StepTolerance;
                if (still || !better || !(gamma_ > restart_margin * goal_).any()) break;
                gamma_at_restart = gamma_;
                restart();
            }
            if (result_.iterations == options_.max_iterations) {
                set_residual();
                result_.stop = CglsStop::MaxIterations;
                break;
            }
            base::report_progress(options_.progress, "solve",
                                  double(result_.iterations) / options_.max_iterations);
            still = iterate() <= options_.step_tolerance && options_.step_tolerance > 0.0;
            ++result_.iterations;
        }
        result_.residual = std::sqrt(residual_.sum());
        result_.normal_residual = s_.norm();
        return std::move(result_);
    }

  private:
    // Below rounding the recurrence still converges while the residual itself does not.
    static constexpr double min_relative_residual = 1e-15;
    // A restart must have reduced |s|^2 to this share to be followed by another.
    static constexpr double restart_gain = 0.25;
    // A residual this little above the goal is not worth a restart.
    static constexpr double restart_margin = 1.1;
    // Of the squared residual: a larger increase than this is not rounding of its sum.
    static constexpr double rounding = 1e-9;

    /// One number a column, or their sum in each when columns share their step lengths.
    [[nodiscard]] Column3 by_step(const Column3& norms) const {
        return options_.joint ? Column3::Constant(norms.sum()).eval() : norms;
    }

    /// Residual and s from x; columns whose residual has grown go back to where it was last
    /// computed. Exact steps never increase it: those that rounding directs do, where s is zero.
    void set_residual() {
        residual_ = a_.normal_residual(b_, result_.x, s_);
        const Column3 now = by_step(residual_);
        if (!(now <= least_residual_ * (1.0 + rounding)).all()) {
            for (int c = 0; c < 3; ++c) {
                if (!(now[c] <= least_residual_[c])) result_.x.col(c) = verified_.col(c);
            }
            residual_ = a_.normal_residual(b_, result_.x, s_);
        }
        least_residual_ = by_step(residual_);
        verified_ = result_.x;
    }

    Column3 preconditioned_norms() {
        const Preconditioner* const b = options_.preconditioner;
        return by_step(b != nullptr ? b->apply_transposed(s_, u_) : squared_norms(s_));
    }

    /// The next direction is that of steepest descent.
    void restart() {
        d_ = s_;
        if (options_.preconditioner != nullptr)
            options_.preconditioner->apply(u_, Column3::Zero(), d_);
    }

    /// One step of all columns that have not converged: directions of the others hold nothing but
    /// rounding. Returns the largest change of an unknown.
    double iterate() {
        const Eigen::Array<bool, 3, 1> open = gamma_ > goal_;
        const Column3 alpha = open.select(ratio(gamma_, by_step(a_.normal_product(d_, t_))), 0.0);
        Column3 norms;
        const double change = take_steps(alpha, norms);
        const Column3 next =
            options_.preconditioner != nullptr ? preconditioned_norms() : by_step(norms);
        const Column3 beta = open.select(ratio(next, gamma_), 0.0);
        if (options_.preconditioner != nullptr) {
            options_.preconditioner->apply(u_, beta, d_);
        } else {
            over_rows<rows_a_task>(d_.rows(), [&](Eigen::Index first, Eigen::Index count) {
                auto block = d_.middleRows(first, count);
                block = s_.middleRows(first, count) + (block * beta.matrix().asDiagonal()).eval();
            });
        }
        gamma_ = next;
        return change;
    }

    /// x += alpha d, s -= alpha t; sets the squared norms of s where no preconditioner needs
    /// others.
    double take_steps(const Column3& alpha, Column3& norms) {
        const std::size_t blocks = (std::size_t(d_.rows()) + rows_a_task - 1) / rows_a_task;
        std::vector<double> change(blocks, 0.0);
        std::vector<Column3> partial(blocks, Column3::Zero());
        over_rows<rows_a_task>(d_.rows(), [&](Eigen::Index first, Eigen::Index count) {
            const auto block = std::size_t(first) / rows_a_task;
            const Eigen::Index at = 3 * first, size = 3 * count;
            const double* sizes =
                options_.unknown_sizes != nullptr ? options_.unknown_sizes->data() + at : nullptr;
            change[block] = take_step(alpha, d_.data() + at, t_.data() + at, sizes, size,
                                      result_.x.data() + at, s_.data() + at);
            if (options_.preconditioner == nullptr) {
                partial[block] =
                    s_.middleRows(first, count).colwise().squaredNorm().transpose().array();
            }
        });
        norms = Column3::Zero();
        for (const Column3& part : partial) norms += part;
        return blocks > 0 ? *std::max_element(change.begin(), change.end())
                          : std::numeric_limits<double>::infinity();
    }

    const LinearOperator& a_;
    const Points& b_;
    const CglsOptions& options_;
    CglsResult result_;
    Points s_, d_, t_, u_;  // A^T r, direction, A^T A d, B^T s
    Points verified_;       // x when the residual was computed from it the last time
    Column3 residual_, least_residual_ = Column3::Constant(std::numeric_limits<double>::infinity());
    Column3 gamma_, goal_;  // |B^T s|^2 by step length
};

}  // namespace

CglsResult solve_cgls(const LinearOperator& a, const Points& b, const Points& start,
                      const CglsOptions& options) {
    check(a, b, start, options);
    return CglsSolve(a, b, start, options).run();
}

}  // namespace patchwright::fit
