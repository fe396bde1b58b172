#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/cgls.h>

#include <algorithm>
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

}  // namespace

Eigen::Array3d LinearOperator::normal_product(const Points& x, Points& t) const {
    Points product;
    apply(x, product);
    apply_transposed(product, t);
    return squared_norms(product);
}

CglsResult solve_cgls(const LinearOperator& a, const Points& b, const Points& start,
                      const CglsOptions& options) {
    if (b.rows() != a.rows() || start.rows() != a.columns()) {
        throw base::InvalidArgument(
            "solve_cgls: sizes of operator, right-hand side and start differ");
    }
    if (options.max_iterations < 0 || !(options.relative_residual >= 0.0) ||
        !(options.least_change >= 0.0)) {
        throw base::InvalidArgument("solve_cgls: iterations and tolerance must not be negative");
    }
    if (options.unknown_sizes != nullptr && options.unknown_sizes->rows() != a.columns()) {
        throw base::InvalidArgument("solve_cgls: unknown_sizes has not one row an unknown");
    }
    const auto steps_of = [&](const Column3& norms) {
        return options.joint ? Column3::Constant(norms.sum()).eval() : norms;
    };
    CglsResult result;
    result.x = start;
    Points r, s, d, t;
    Points safe = start;  // where the residual was made from x the last time
    Column3 least_residual = Column3::Constant(std::numeric_limits<double>::infinity());
    const auto set_residual = [&] {
        a.apply(result.x, r);
        r = b - r;
        // Every step makes it smaller but those that rounding alone directs, where A^T r is zero.
        const Column3 now = steps_of(squared_norms(r));
        if (!(now <= least_residual * (1.0 + 1e-9)).all()) {
            for (int c = 0; c < 3; ++c) {
                if (!(now[c] <= least_residual[c])) result.x.col(c) = safe.col(c);
            }
            a.apply(result.x, r);
            r = b - r;
        }
        least_residual = steps_of(squared_norms(r));
        safe = result.x;
        a.apply_transposed(r, s);
    };
    set_residual();
    Column3 gamma = steps_of(squared_norms(s));
    // Below rounding the recurrence goes on where the truth cannot follow.
    const double wanted = std::max(options.relative_residual, 1e-15);
    const Column3 goal = gamma * wanted * wanted;
    Column3 least = gamma;  // when the residual was made anew the last time
    d = s;
    bool still = false;
    for (;;) {
        if (still || !(gamma > goal).any()) {
            // What rounding has put between the recurrence and the truth shows here.
            if (result.iterations > 0) set_residual();
            gamma = steps_of(squared_norms(s));
            const bool better = (gamma < 0.25 * least || gamma <= goal).all();
            if (still && (gamma > goal).any()) result.stop = CglsStop::LeastChange;
            if (still || !better || !(gamma > 1.1 * goal).any()) break;
            least = gamma;
            d = s;
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
        over_rows(d.rows(), [&](Eigen::Index first, Eigen::Index count) {
            const auto block = std::size_t(first) / grain;
            const auto step = d.middleRows(first, count) * alpha.matrix().asDiagonal();
            if (options.least_change > 0.0) {
                Points moved = step;
                if (options.unknown_sizes != nullptr)
                    moved = moved.cwiseProduct(options.unknown_sizes->middleRows(first, count));
                change[block] = moved.cwiseAbs().maxCoeff();
            }
            result.x.middleRows(first, count).noalias() += step;
            s.middleRows(first, count).noalias() -=
                t.middleRows(first, count) * alpha.matrix().asDiagonal();
            norms[block] = s.middleRows(first, count).colwise().squaredNorm().transpose().array();
        });
        Column3 sum = Column3::Zero();
        for (const Column3& part : norms) sum += part;
        const Column3 next = steps_of(sum);
        const Column3 beta = open.select(ratio(next, gamma), 0.0);
        over_rows(d.rows(), [&](Eigen::Index first, Eigen::Index count) {
            auto block = d.middleRows(first, count);
            block = s.middleRows(first, count) + (block * beta.matrix().asDiagonal()).eval();
        });
        gamma = next;
        ++result.iterations;
        still = options.least_change > 0.0 && blocks > 0 &&
                *std::max_element(change.begin(), change.end()) <= options.least_change;
    }
    result.residual = r.norm();
    result.normal_residual = s.norm();
    return result;
}

}  // namespace patchwright::fit
