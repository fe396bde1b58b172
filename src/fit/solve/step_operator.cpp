#include "fit/solve/step_operator.h"

#include "fit/solve/over_rows.h"
#include "geom/symmetric_eigen.h"
#include "subd/solver_products.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace patchwright::fit {

using geom::Points;

namespace {

using Rows = subd::LimitOperator::Rows;
using Block = MeshPreconditioner::Block;

constexpr std::size_t step_rows_a_task = 4096;  // rows a task

/// The square root of the quadratic form that measures a row: across + difference n n^T.
struct RowWeight {
    const double* n;
    double across, difference;

    RowWeight(const SampleWeights& weights, Eigen::Index i) : n(weights.direction.data() + 3 * i) {
        const bool none = n[0] == 0.0 && n[1] == 0.0 && n[2] == 0.0;
        const double weight = weights.weight.size() > 0 ? weights.weight[i] : 1.0;
        const double part = none                               ? weights.without
                            : weights.across_by_row.size() > 0 ? weights.across_by_row[i]
                                                               : weights.across;
        across = weight * part;
        difference = none ? 0.0 : weight * (weights.along - part);
    }
    void apply(double* r) const {
        const double along = difference * (n[0] * r[0] + n[1] * r[1] + n[2] * r[2]);
        for (int c = 0; c < 3; ++c) r[c] = across * r[c] + along * n[c];
    }
};

/// to = rows, weighted; they may be the same.
void weigh(const SampleWeights& weights, const Points& rows, Eigen::Index at, Points& to) {
    over_rows<step_rows_a_task>(rows.rows(), [&](Eigen::Index first, Eigen::Index count) {
        for (Eigen::Index i = first; i < first + count; ++i) {
            Eigen::RowVector3d r = rows.row(i);
            RowWeight(weights, i).apply(r.data());
            to.row(at + i) = r;
        }
    });
}

/// Of the weights of each site's rows.
Eigen::VectorXd largest_squares(const subd::LimitOperator& samples, const SampleWeights& weights) {
    const auto& rows = samples.site_rows();
    Eigen::VectorXd squares(Eigen::Index(rows.size()) - 1);
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        const auto of_site = [&](const Eigen::VectorXd& by_row, double otherwise) {
            if (by_row.size() == 0) return otherwise;
            return by_row.segment(rows[site], rows[site + 1] - rows[site]).maxCoeff();
        };
        const double across = of_site(weights.across_by_row, weights.across);
        const double largest =
            of_site(weights.weight, 1.0) * std::max({weights.along, weights.without, across});
        squares[Eigen::Index(site)] = largest * largest;
    }
    return squares;
}

}  // namespace

StepOperator::StepOperator(const subd::LimitOperator& samples, const SampleWeights& weights,
                           const subd::LimitOperator& bending, const SampleWeights& stiffness,
                           const Eigen::VectorXd& damping, const PointConstraints& constraints)
    : samples_(samples),
      weights_(weights),
      bending_(bending),
      stiffness_(stiffness),
      root_damping_(damping.cwiseSqrt()),
      constraints_(constraints) {
    const Eigen::VectorXd squares =
        subd::SolverProducts(samples).column_squares() +
        subd::SolverProducts(bending).column_squares(largest_squares(bending, stiffness));
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
    move(x, moved_);
    samples_.apply(moved_, part_);
    weigh(weights_, part_, 0, y);
    bending_.apply(moved_, part_);
    weigh(stiffness_, part_, samples_.rows(), y);
    y.bottomRows(columns()) = root_damping_.asDiagonal() * x;
}

void StepOperator::apply_transposed(const Points& y, Points& x) const {
    part_ = y.topRows(samples_.rows());
    weigh(weights_, part_, 0, part_);
    samples_.apply_transposed(part_, x);
    part_ = y.middleRows(samples_.rows(), bending_.rows());
    weigh(stiffness_, part_, 0, part_);
    bending_.apply_transposed(part_, sum_);
    gather(x, sum_, [&](Eigen::Index first, auto rows) {
        rows += root_damping_.segment(first, rows.rows()).asDiagonal() *
                y.middleRows(samples_.rows() + bending_.rows() + first, rows.rows());
    });
}

template <class Also>
void StepOperator::gather(Points& from_samples, const Points& from_bending,
                          const Also& also) const {
    over_rows<step_rows_a_task>(from_samples.rows(), [&](Eigen::Index first, Eigen::Index count) {
        from_samples.middleRows(first, count) += from_bending.middleRows(first, count);
    });
    constraints_.complete_transposed(from_samples);
    over_rows<step_rows_a_task>(from_samples.rows(), [&](Eigen::Index first, Eigen::Index count) {
        auto rows = from_samples.middleRows(first, count);
        rows = rows.cwiseProduct(scale_.middleRows(first, count));
        also(first, rows);
    });
}

Eigen::Array3d StepOperator::normal_product(const Points& x, Points& t) const {
    move(x, moved_);
    const auto weighted = [](const SampleWeights& weights) {
        return [&weights](Eigen::Index first, Rows rows) -> Eigen::Array3d {
            Eigen::Array3d norms = Eigen::Array3d::Zero();
            double* r = rows.data();
            for (Eigen::Index i = 0; i < rows.rows(); ++i, r += 3) {
                const RowWeight weight(weights, first + i);
                weight.apply(r);
                for (int c = 0; c < 3; ++c) norms[c] += r[c] * r[c];
                weight.apply(r);
            }
            return norms;
        };
    };
    Eigen::Array3d norms =
        subd::SolverProducts(samples_).normal_product(moved_, t, weighted(weights_));
    norms += subd::SolverProducts(bending_).normal_product(moved_, sum_, weighted(stiffness_));
    std::vector<Eigen::Array3d> partial(std::size_t(x.rows()) / step_rows_a_task + 1,
                                        Eigen::Array3d::Zero());
    gather(t, sum_, [&](Eigen::Index first, auto rows) {
        const auto root = root_damping_.segment(first, rows.rows()).asDiagonal();
        const Points damped = root * x.middleRows(first, rows.rows());
        rows += root * damped;
        partial[std::size_t(first) / step_rows_a_task] = damped.colwise().squaredNorm().transpose();
    });
    for (const Eigen::Array3d& part : partial) norms += part;
    return norms;
}

Eigen::Array3d StepOperator::normal_residual(const Points& b, const Points& x, Points& s) const {
    move(x, moved_);
    const auto from = [&b](const SampleWeights& weights, Eigen::Index begin) {
        return [&b, &weights, begin](Eigen::Index first, Rows rows) -> Eigen::Array3d {
            Eigen::Array3d norms = Eigen::Array3d::Zero();
            double* r = rows.data();
            const double* wanted = b.data() + 3 * (begin + first);
            for (Eigen::Index i = 0; i < rows.rows(); ++i, r += 3, wanted += 3) {
                const RowWeight weight(weights, first + i);
                weight.apply(r);
                for (int c = 0; c < 3; ++c) {
                    r[c] = wanted[c] - r[c];
                    norms[c] += r[c] * r[c];
                }
                weight.apply(r);
            }
            return norms;
        };
    };
    Eigen::Array3d norms =
        subd::SolverProducts(samples_).normal_product(moved_, s, from(weights_, 0));
    norms += subd::SolverProducts(bending_).normal_product(moved_, sum_,
                                                           from(stiffness_, samples_.rows()));
    std::vector<Eigen::Array3d> partial(std::size_t(x.rows()) / step_rows_a_task + 1,
                                        Eigen::Array3d::Zero());
    const Eigen::Index damped = samples_.rows() + bending_.rows();
    gather(s, sum_, [&](Eigen::Index first, auto rows) {
        const auto root = root_damping_.segment(first, rows.rows()).asDiagonal();
        const Points left =
            b.middleRows(damped + first, rows.rows()) - root * x.middleRows(first, rows.rows());
        rows += root * left;
        partial[std::size_t(first) / step_rows_a_task] = left.colwise().squaredNorm().transpose();
    });
    for (const Eigen::Array3d& part : partial) norms += part;
    return norms;
}

Points StepOperator::right_side(const Points& sample_changes, const Points& bending_changes) const {
    Points b(rows(), 3);
    weigh(weights_, sample_changes, 0, b);
    weigh(stiffness_, bending_changes, samples_.rows(), b);
    b.bottomRows(columns()).setZero();
    return b;
}

void StepOperator::move(const Points& x, Points& moved) const {
    moved.resize(x.rows(), 3);
    over_rows<step_rows_a_task>(x.rows(), [&](Eigen::Index first, Eigen::Index count) {
        moved.middleRows(first, count) =
            x.middleRows(first, count).cwiseProduct(scale_.middleRows(first, count));
    });
    constraints_.complete(moved);
}

Points StepOperator::displacements(const Points& x) const {
    Points moved;
    move(x, moved);
    return moved;
}

namespace {

/// Diagonal and off-diagonal entries of each vertex's block of M^T W^2 M.
void weighted_blocks(const subd::LimitOperator& rows, const SampleWeights& weights,
                     Points& diagonal, Points& off) {
    Points squares(rows.rows(), 3);
    const auto set = [&](bool on_diagonal, Points& sums) {
        over_rows<step_rows_a_task>(squares.rows(), [&](Eigen::Index first, Eigen::Index count) {
            for (Eigen::Index i = first; i < first + count; ++i) {
                const RowWeight w(weights, i);
                const double along = w.across + w.difference;
                const double across = w.across * w.across, both = along * along - across;
                const double* n = w.n;
                if (on_diagonal) {
                    squares.row(i) << across + both * n[0] * n[0], across + both * n[1] * n[1],
                        across + both * n[2] * n[2];
                } else {
                    squares.row(i) << both * n[0] * n[1], both * n[0] * n[2], both * n[1] * n[2];
                }
            }
        });
        subd::SolverProducts(rows).apply_squares_transposed(squares, sums);
    };
    set(true, diagonal);
    set(false, off);
}

Eigen::Matrix3d block_at(const Points& diagonal, const Points& off, Eigen::Index v) {
    Eigen::Matrix3d m;
    m << diagonal(v, 0), off(v, 0), off(v, 1), off(v, 0), diagonal(v, 1), off(v, 2), off(v, 1),
        off(v, 2), diagonal(v, 2);
    return m;
}

/// With which a of MeshPreconditioner the wave that alternates in one direction has the length of
/// a constant one. Samples leave 17/315 of it; bending adds 16/3, of a diagonal that is 15 times
/// that of the samples (cubic B-splines: mass 151/315, second derivatives 8/3, first 2/3).
double alternation(double bending_over_samples) {
    const double left = 17.0 / 315.0 + bending_over_samples / 15.0 * 16.0 / 3.0;
    return std::max(0.0, (1.0 / std::sqrt(left) - 1.0) / 4.0);
}

}  // namespace

void StepOperator::precondition(MeshPreconditioner& preconditioner) const {
    Points sample_diagonal, sample_off, bending_diagonal, bending_off;
    weighted_blocks(samples_, weights_, sample_diagonal, sample_off);
    weighted_blocks(bending_, stiffness_, bending_diagonal, bending_off);
    std::vector<Block> blocks(static_cast<std::size_t>(columns()));
    std::vector<double> sums(blocks.size() / step_rows_a_task + 1, 0.0), counts(sums.size(), 0.0);
    over_rows<step_rows_a_task>(columns(), [&](Eigen::Index first, Eigen::Index count) {
        for (Eigen::Index v = first; v < first + count; ++v) {
            const Eigen::Vector3d scale = scale_.row(v).transpose();
            const Eigen::Matrix3d by_scale = scale * scale.transpose();
            const Eigen::Matrix3d bending =
                block_at(bending_diagonal, bending_off, v).cwiseProduct(by_scale);
            Eigen::Matrix3d all =
                block_at(sample_diagonal, sample_off, v).cwiseProduct(by_scale) + bending;
            for (int c = 0; c < 3; ++c)
                all(c, c) = scale[c] > 0.0 ? all(c, c) + std::pow(root_damping_[v], 2) : 1.0;
            const geom::SymmetricEigen eigen = geom::symmetric_eigen(all);
            const Eigen::Vector3d lengths =
                eigen.values.cwiseMax(1e-12 * std::max(1.0, eigen.values[2])).cwiseSqrt();
            const Eigen::Matrix3d& axes = eigen.vectors;
            const Eigen::Matrix3d g = axes * lengths.cwiseInverse().asDiagonal() * axes.transpose();
            blocks[std::size_t(v)] = {g(0, 0), g(1, 1), g(2, 2), g(0, 1), g(0, 2), g(1, 2)};
            if (!(scale.minCoeff() > 0.0)) continue;
            double least = MeshPreconditioner::mass;
            for (int k = 0; k < 3; ++k) {
                const double of_bending = axes.col(k).dot(bending * axes.col(k));
                const double of_samples = eigen.values[k] - of_bending;
                if (of_samples > 0.0) least = std::min(least, alternation(of_bending / of_samples));
            }
            sums[std::size_t(first) / step_rows_a_task] += least;
            counts[std::size_t(first) / step_rows_a_task] += 1.0;
        }
    });
    const double count = std::accumulate(counts.begin(), counts.end(), 0.0);
    const double a = count > 0.0 ? std::accumulate(sums.begin(), sums.end(), 0.0) / count : 0.0;
    preconditioner.set(a, std::move(blocks));
}

}  // namespace patchwright::fit
