// A limit operator's rows as a least-squares problem.
#pragma once

#include <patchwright/fit/cgls.h>
#include <patchwright/subd/limit_operator.h>

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
        return limit_.normal_product(x, t);
    }

  private:
    const subd::LimitOperator& limit_;
};

}  // namespace patchwright::fit
