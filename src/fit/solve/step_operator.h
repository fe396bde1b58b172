// The linear least-squares problem of one step of a fit.
#pragma once

#include "fit/solve/cgls.h"
#include "fit/solve/constraints.h"
#include "fit/solve/mesh_preconditioner.h"

#include <patchwright/subd/limit_operator.h>

namespace patchwright::fit {

/// How the residual of a sample counts: `along` its direction, `across` it, all of it times
/// `weight`. Surfaces have their normal as direction, along 1: across is 1 for point distance and 0
/// for tangent distance. Curves have their tangent, across 1.
struct SampleWeights {
    geom::Points direction;  ///< samples x 3, unit; or zero: there is none
    Eigen::VectorXd weight;  ///< samples; or empty: ones
    double along = 1.0;
    double across = 1.0;
    Eigen::VectorXd across_by_row;  ///< in place of `across` unless empty
    double without = 1.0;           ///< in place of both where there is no direction
};

/// Rows: weighted samples, weighted second derivatives of the surface, damping of the step.
/// Unknowns are displacements of the control points scaled so that all columns have about the same
/// length.
class StepOperator final : public LinearOperator {
  public:
    /// @param stiffness  of the rows of `bending`
    /// @param damping    of each control point: factor of its squared scaled step (Levenberg,
    ///                   Marquardt)
    StepOperator(const subd::LimitOperator& samples, const SampleWeights& weights,
                 const subd::LimitOperator& bending, const SampleWeights& stiffness,
                 const Eigen::VectorXd& damping, const PointConstraints& constraints);

    [[nodiscard]] Eigen::Index rows() const override;
    [[nodiscard]] Eigen::Index columns() const override { return samples_.columns(); }
    void apply(const geom::Points& x, geom::Points& y) const override;
    void apply_transposed(const geom::Points& y, geom::Points& x) const override;
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t) const override;
    Eigen::Array3d normal_residual(const geom::Points& b, const geom::Points& x,
                                   geom::Points& s) const override;

    /// The right-hand side that asks for these changes of the samples and second derivatives.
    [[nodiscard]] geom::Points right_side(const geom::Points& sample_changes,
                                          const geom::Points& bending_changes) const;
    /// Displacements of the control points from a solution.
    [[nodiscard]] geom::Points displacements(const geom::Points& x) const;

    /// Sets unknowns that suit the normal matrix: its blocks, and how much more bending than
    /// samples hold what alternates.
    void precondition(MeshPreconditioner& preconditioner) const;

    /// By how much a change of 1 in each unknown moves its control point.
    [[nodiscard]] const geom::Points& scale() const { return scale_; }

  private:
    /// Both parts' transposed products to unknowns, in place of the first, with `also` called for
    /// (first row, rows) once they are there.
    template <class Also>
    void gather(geom::Points& from_samples, const geom::Points& from_bending,
                const Also& also) const;
    void move(const geom::Points& x, geom::Points& moved) const;

    const subd::LimitOperator& samples_;
    const SampleWeights& weights_;
    const subd::LimitOperator& bending_;
    const SampleWeights& stiffness_;
    Eigen::VectorXd root_damping_;
    const PointConstraints& constraints_;
    geom::Points scale_;  // zero where held
    // Products are made one after the other; the buffers spare their allocation.
    mutable geom::Points part_, sum_, moved_;
};

}  // namespace patchwright::fit
