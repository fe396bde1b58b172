#include "fit/step_operator.h"

#include <patchwright/base/parallel.h>

#include <cmath>

namespace patchwright::fit {

using geom::Points;

void weigh(const SampleWeights& weights, Points& rows) {
    base::parallel_for(
        std::size_t(weights.weight.size()), 4096, [&](std::size_t first, std::size_t last) {
            for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
                const Eigen::RowVector3d n = weights.direction.row(i);
                const Eigen::RowVector3d r = rows.row(i);
                const double across = n.isZero() ? 1.0 : weights.across;
                rows.row(i) =
                    weights.weight[i] * (across * r + (weights.along - across) * r.dot(n) * n);
            }
        });
}

StepOperator::StepOperator(const subd::LimitOperator& samples, const SampleWeights& weights,
                           const subd::LimitOperator& bending, double fairness, double damping,
                           const PointConstraints& constraints)
    : samples_(samples),
      weights_(weights),
      bending_(bending),
      root_fairness_(std::sqrt(fairness)),
      root_damping_(std::sqrt(damping)),
      constraints_(constraints) {
    const Eigen::VectorXd squares = samples.column_squares() + fairness * bending.column_squares();
    scale_ = squares.replicate<1, 3>();
    constraints.gather(scale_);
    for (Eigen::Index v = 0; v < scale_.rows(); ++v) {
        for (int c = 0; c < 3; ++c) {
            const bool held = (constraints.held[std::size_t(v)] >> c & 1) != 0;
            scale_(v, c) = !held && scale_(v, c) > 0.0 ? 1.0 / std::sqrt(scale_(v, c)) : 0.0;
        }
    }
}

Eigen::Index StepOperator::rows() const {
    return samples_.rows() + bending_.rows() + samples_.columns();
}

void StepOperator::apply(const Points& x, Points& y) const {
    y.resize(rows(), 3);
    scaled_ = displacements(x);
    samples_.apply(scaled_, part_);
    weigh(weights_, part_);
    y.topRows(samples_.rows()) = part_;
    bending_.apply(scaled_, part_);
    y.middleRows(samples_.rows(), bending_.rows()) = root_fairness_ * part_;
    y.bottomRows(columns()) = root_damping_ * x;
}

void StepOperator::apply_transposed(const Points& y, Points& x) const {
    part_ = y.topRows(samples_.rows());
    weigh(weights_, part_);
    samples_.apply_transposed(part_, x);
    part_ = root_fairness_ * y.middleRows(samples_.rows(), bending_.rows());
    bending_.apply_transposed(part_, sum_);
    x += sum_;
    constraints_.gather(x);
    x = x.cwiseProduct(scale_) + root_damping_ * y.bottomRows(columns());
}

Points StepOperator::right_side(const Points& sample_changes, const Points& points) const {
    Points b = Points::Zero(rows(), 3);
    part_ = sample_changes;
    weigh(weights_, part_);
    b.topRows(samples_.rows()) = part_;
    bending_.apply(points, part_);
    b.middleRows(samples_.rows(), bending_.rows()) = -root_fairness_ * part_;
    return b;
}

Points StepOperator::displacements(const Points& x) const {
    Points moved = x.cwiseProduct(scale_);
    constraints_.follow(moved);
    return moved;
}

}  // namespace patchwright::fit
