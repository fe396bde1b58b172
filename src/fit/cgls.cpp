#include <patchwright/base/error.h>
#include <patchwright/fit/cgls.h>

namespace patchwright::fit {

namespace {

using Row3 = Eigen::Array<double, 1, 3>;

Row3 squared_norms(const geom::Points& p, bool joint) {
    const Row3 norms = p.colwise().squaredNorm().array();
    return joint ? Row3::Constant(norms.sum()) : norms;
}

/// a / b by column; 0 where b is 0, which stops that column.
Row3 ratio(const Row3& a, const Row3& b) { return (b > 0.0).select(a / b.max(1e-300), 0.0); }

void add_scaled(geom::Points& to, const Row3& factor, const geom::Points& what) {
    to.noalias() += what * factor.matrix().asDiagonal();
}

}  // namespace

CglsResult solve_cgls(const LinearOperator& a, const geom::Points& b, const geom::Points& start,
                      const CglsOptions& options) {
    if (b.rows() != a.rows() || start.rows() != a.columns()) {
        throw base::InvalidArgument(
            "solve_cgls: sizes of operator, right-hand side and start differ");
    }
    if (options.max_iterations < 0 || !(options.relative_residual >= 0.0)) {
        throw base::InvalidArgument("solve_cgls: iterations and tolerance must not be negative");
    }
    CglsResult result;
    result.x = start;
    geom::Points product;
    a.apply(start, product);
    geom::Points r = b - product;
    geom::Points s;
    a.apply_transposed(r, s);
    geom::Points d = s;
    Row3 gamma = squared_norms(s, options.joint);
    const Row3 goal = gamma * options.relative_residual * options.relative_residual;
    while ((gamma > goal).any()) {
        if (result.iterations == options.max_iterations) {
            result.stop = CglsStop::MaxIterations;
            break;
        }
        base::report_progress(options.progress, "solve",
                              double(result.iterations) / options.max_iterations);
        a.apply(d, product);
        const Row3 alpha = ratio(gamma, squared_norms(product, options.joint));
        add_scaled(result.x, alpha, d);
        add_scaled(r, -alpha, product);
        a.apply_transposed(r, s);
        const Row3 next = squared_norms(s, options.joint);
        d = (s + d * ratio(next, gamma).matrix().asDiagonal()).eval();
        gamma = next;
        ++result.iterations;
    }
    result.residual = r.norm();
    result.normal_residual = s.norm();
    return result;
}

}  // namespace patchwright::fit
