#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/cgls.h>

#include <algorithm>
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

void add_scaled(Points& to, const Column3& factor, const Points& what) {
    over_rows(to.rows(), [&](Eigen::Index first, Eigen::Index count) {
        to.middleRows(first, count).noalias() +=
            what.middleRows(first, count) * factor.matrix().asDiagonal();
    });
}

}  // namespace

Eigen::Array3d LinearOperator::apply_with_norms(const Points& x, Points& y) const {
    apply(x, y);
    return squared_norms(y);
}

void LinearOperator::subtract_and_transpose(const Eigen::Array3d& factor, const Points& q,
                                            Points& r, Points& x) const {
    add_scaled(r, -factor, q);
    apply_transposed(r, x);
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
    const auto steps_of = [&](const Column3& norms) {
        return options.joint ? Column3::Constant(norms.sum()).eval() : norms;
    };
    CglsResult result;
    result.x = start;
    Points product, s;
    a.apply(start, product);
    Points r = b;
    a.subtract_and_transpose(Column3::Ones(), product, r, s);
    Points d = s;
    Column3 gamma = steps_of(squared_norms(s));
    const Column3 goal = gamma * options.relative_residual * options.relative_residual;
    while ((gamma > goal).any()) {
        if (result.iterations == options.max_iterations) {
            result.stop = CglsStop::MaxIterations;
            break;
        }
        base::report_progress(options.progress, "solve",
                              double(result.iterations) / options.max_iterations);
        const Column3 alpha = ratio(gamma, steps_of(a.apply_with_norms(d, product)));
        a.subtract_and_transpose(alpha, product, r, s);
        const Column3 next = steps_of(squared_norms(s));
        const Column3 beta = ratio(next, gamma);
        std::vector<double> change((std::size_t(d.rows()) + grain - 1) / grain, 0.0);
        over_rows(d.rows(), [&](Eigen::Index first, Eigen::Index count) {
            auto block = d.middleRows(first, count);
            if (options.least_change > 0.0) {
                change[std::size_t(first) / grain] =
                    (block * alpha.matrix().asDiagonal()).cwiseAbs().maxCoeff();
            }
            result.x.middleRows(first, count).noalias() += block * alpha.matrix().asDiagonal();
            block = s.middleRows(first, count) + (block * beta.matrix().asDiagonal()).eval();
        });
        gamma = next;
        ++result.iterations;
        if (options.least_change > 0.0 &&
            *std::max_element(change.begin(), change.end()) <= options.least_change) {
            break;
        }
    }
    result.residual = r.norm();
    result.normal_residual = s.norm();
    return result;
}

}  // namespace patchwright::fit
