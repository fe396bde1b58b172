// The linear least-squares problem of one step of a fit.
#pragma once

#include "fit/constraints.h"

#include <patchwright/fit/cgls.h>
#include <patchwright/subd/limit_operator.h>

namespace patchwright::fit {

/// How the residual of a sample counts: `along` its direction, `across` it, all of it times
/// `weight`. Surfaces have their normal as direction, along 1: across is 1 for point distance and 0
/// for tangent distance. Curves have their tangent, across 1.
struct SampleWeights {
    geom::Points direction;  ///< samples x 3, unit; zero: the residual counts fully
    Eigen::VectorXd weight;  ///< samples
    double along = 1.0;
    double across = 1.0;
};

/// Multiplies each row by its weight: the square root of the quadratic form that measures it.
void weigh(const SampleWeights& weights, geom::Points& rows);

/// Rows: weighted samples, bending of the surface, damping of the step. Unknowns are displacements
/// of the control points scaled so that all columns have about the same length.
class StepOperator final : public LinearOperator {
  public:
    /// @param fairness  factor of the bending energy
    /// @param damping   factor of the squared scaled step (Levenberg, Marquardt)
    StepOperator(const subd::LimitOperator& samples, const SampleWeights& weights,
                 const subd::LimitOperator& bending, double fairness, double damping,
                 const PointConstraints& constraints);

    [[nodiscard]] Eigen::Index rows() const override;
    [[nodiscard]] Eigen::Index columns() const override { return samples_.columns(); }
    void apply(const geom::Points& x, geom::Points& y) const override;
    void apply_transposed(const geom::Points& y, geom::Points& x) const override;

    /// The right-hand side that asks for these changes of the samples and no bending.
    [[nodiscard]] geom::Points right_side(const geom::Points& sample_changes,
                                          const geom::Points& points) const;
    /// Displacements of the control points from a solution.
    [[nodiscard]] geom::Points displacements(const geom::Points& x) const;

  private:
    const subd::LimitOperator& samples_;
    const SampleWeights& weights_;
    const subd::LimitOperator& bending_;
    double root_fairness_;
    double root_damping_;
    const PointConstraints& constraints_;
    geom::Points scale_;  // zero where held
    // Products are made one after the other; the buffers spare their allocation.
    mutable geom::Points scaled_, part_, sum_;
};

}  // namespace patchwright::fit
