// Conjugate gradients for linear least squares, three right-hand sides in one sweep.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::fit {

/// A matrix that is known by its products only.
class LinearOperator {
  public:
    virtual ~LinearOperator() = default;
    [[nodiscard]] virtual Eigen::Index rows() const = 0;
    [[nodiscard]] virtual Eigen::Index columns() const = 0;
    /// y = A x; y is resized to rows() x 3.
    virtual void apply(const geom::Points& x, geom::Points& y) const = 0;
    /// x = A^T y; x is resized to columns() x 3.
    virtual void apply_transposed(const geom::Points& y, geom::Points& x) const = 0;

    // The two steps of an iteration that touch rows; operators that can make them in one sweep
    // over memory override them. Sums must not depend on the number of threads.
    /// y = A x; returns the squared norm of each column of y.
    virtual Eigen::Array3d apply_with_norms(const geom::Points& x, geom::Points& y) const;
    /// r -= q times `factor` by column; x = A^T r.
    virtual void subtract_and_transpose(const Eigen::Array3d& factor, const geom::Points& q,
                                        geom::Points& r, geom::Points& x) const;
};

struct CglsOptions {
    int max_iterations = 100;  ///< K
    double relative_residual =
        1e-10;  ///< stop at |A^T r| <= this * |A^T r| of the start, by column
    /// Stop, too, when a step changes no unknown by more than this; in their unit.
    double least_change = 0.0;
    /// One step length for all three coordinates: for operators that mix them.
    bool joint = false;
    base::Progress progress;
};

enum class CglsStop { Converged, MaxIterations };

struct CglsResult {
    geom::Points x;
    int iterations = 0;
    double residual = 0.0;         ///< |b - A x|, Frobenius
    double normal_residual = 0.0;  ///< |A^T (b - A x)|, Frobenius
    CglsStop stop = CglsStop::Converged;
};

/// Least-squares solution of A x = b for three coordinates at once, without forming A^T A. Unless
/// they are joint, each coordinate has its own step lengths, so the answer is that of three
/// separate solves. Source: Saad, Iterative Methods for Sparse Linear Systems (2003), 8.3 (CGNR).
/// @pre   b.rows() == a.rows(), start.rows() == a.columns()
/// @throw InvalidArgument when a precondition fails or an option is out of range
/// Not converging is an answer, not an error: see CglsResult::stop.
CglsResult solve_cgls(const LinearOperator& a, const geom::Points& b, const geom::Points& start,
                      const CglsOptions& options = {});

}  // namespace patchwright::fit
