#include "fit/step_operator.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using geom::Points;

namespace {

using Rows = subd::LimitOperator::Rows;

/// Multiplies rows from `first` on by their weights: the square root of the quadratic form that
/// measures them.
template <class AnyRows>
void weigh(const SampleWeights& weights, Eigen::Index first, AnyRows& rows) {
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        const Eigen::RowVector3d n = weights.direction.row(first + i);
        const Eigen::RowVector3d r = rows.row(i);
        const double across = n.isZero()                         ? weights.without
                              : weights.across_by_row.size() > 0 ? weights.across_by_row[first + i]
                                                                 : weights.across;
        rows.row(i) =
            weights.weight[first + i] * (across * r + (weights.along - across) * r.dot(n) * n);
    }
}

void weigh_all(const SampleWeights& weights, Points& rows) {
    base::parallel_for(std::size_t(rows.rows()), 4096, [&](std::size_t first, std::size_t last) {
        auto block = rows.middleRows(Eigen::Index(first), Eigen::Index(last - first));
        weigh(weights, Eigen::Index(first), block);
    });
}

/// Of the weights of each site's rows.
Eigen::VectorXd largest_squares(const subd::LimitOperator& samples, const SampleWeights& weights) {
    const auto& rows = samples.site_rows();
    Eigen::VectorXd squares(Eigen::Index(rows.size()) - 1);
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        double largest = std::max({weights.along, weights.across, weights.without});
        if (weights.across_by_row.size() > 0) {
            const auto across =
                weights.across_by_row.segment(rows[site], rows[site + 1] - rows[site]);
            largest = std::max({weights.along, weights.without, across.maxCoeff()});
        }
        squares[Eigen::Index(site)] = largest * largest;
    }
    return squares;
}

}  // namespace

StepOperator::StepOperator(const subd::LimitOperator& samples, const SampleWeights& weights,
                           const subd::LimitOperator& bending, const SampleWeights& stiffness,
                           double damping, const PointConstraints& constraints)
    : samples_(samples),
      weights_(weights),
      bending_(bending),
      stiffness_(stiffness),
      root_damping_(std::sqrt(damping)),
      constraints_(constraints) {
    const Eigen::VectorXd squares =
        samples.column_squares() + bending.column_squares(largest_squares(bending, stiffness));
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
    const Points moved = displacements(x);
    samples_.apply(moved, part_);
    weigh_all(weights_, part_);
    y.topRows(samples_.rows()) = part_;
    bending_.apply(moved, part_);
    weigh_all(stiffness_, part_);
    y.middleRows(samples_.rows(), bending_.rows()) = part_;
    y.bottomRows(columns()) = root_damping_ * x;
}

void StepOperator::apply_transposed(const Points& y, Points& x) const {
    part_ = y.topRows(samples_.rows());
    weigh_all(weights_, part_);
    samples_.apply_transposed(part_, x);
    part_ = y.middleRows(samples_.rows(), bending_.rows());
    weigh_all(stiffness_, part_);
    bending_.apply_transposed(part_, sum_);
    gather(x, sum_, root_damping_ * y.bottomRows(columns()));
}

void StepOperator::gather(Points& from_samples, const Points& from_bending,
                          const Points& damped) const {
    from_samples += from_bending;
    constraints_.gather(from_samples);
    from_samples = from_samples.cwiseProduct(scale_) + damped;
}

Eigen::Array3d StepOperator::normal_product(const Points& x, Points& t) const {
    const Points moved = displacements(x);
    const auto weighted = [](const SampleWeights& weights) {
        return [&weights](Eigen::Index first, Rows rows) -> Eigen::Array3d {
            weigh(weights, first, rows);
            const Eigen::Array3d norms = rows.colwise().squaredNorm().transpose();
            weigh(weights, first, rows);
            return norms;
        };
    };
    const Eigen::Array3d samples = samples_.normal_product(moved, t, weighted(weights_));
    const Eigen::Array3d bending = bending_.normal_product(moved, sum_, weighted(stiffness_));
    const Eigen::Array3d step = x.colwise().squaredNorm().transpose();
    const double damping = root_damping_ * root_damping_;
    gather(t, sum_, damping * x);
    return samples + bending + damping * step;
}

Points StepOperator::right_side(Points sample_changes, Points bending_changes) const {
    Points b = Points::Zero(rows(), 3);
    weigh_all(weights_, sample_changes);
    b.topRows(samples_.rows()) = sample_changes;
    weigh_all(stiffness_, bending_changes);
    b.middleRows(samples_.rows(), bending_.rows()) = bending_changes;
    return b;
}

Points StepOperator::displacements(const Points& x) const {
    Points moved = x.cwiseProduct(scale_);
    constraints_.follow(moved);
    return moved;
}

}  // namespace patchwright::fit
