// A limit operator's rows as a least-squares problem.
#pragma once

#include "fit/solve/cgls.h"
#include "subd/solver_products.h"

namespace patchwright::fit {

/// Refers to the operator.
class LimitRows final : public LinearOperator {
  public:
    explicit LimitRows(const subd::LimitOperator& limit) : limit_(limit) {}
    [[nodiscard]] Eigen::Index rows() const override { return limit_.rows(); }
    [[nodiscard]] Eigen::Index columns() const override { return limit_.columns(); }
    void apply(const geom::Points& x, geom::Points& y) const override { limit_.apply(x, y); }
    void apply_transposed(const geom::Points& y, geom::Points& x) const override {
        limit_.apply_transposed(y, x);
    }
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t) const override {
        return subd::SolverProducts(limit_).normal_product(x, t);
    }
    Eigen::Array3d normal_residual(const geom::Points& b, const geom::Points& x,
                                   geom::Points& s) const override {
        return subd::SolverProducts(limit_).normal_product(
            x, s, [&](Eigen::Index first, subd::LimitOperator::Rows rows) -> Eigen::Array3d {
                rows = b.middleRows(first, rows.rows()) - rows;
                return rows.colwise().squaredNorm().transpose();
            });
    }

  private:
    const subd::LimitOperator& limit_;
};

}  // namespace patchwright::fit
