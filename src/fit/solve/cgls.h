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

    /// t = A^T A x in one sweep over the rows where operators know one; returns the squared norm of
    /// each column of A x. Sums must not depend on the number of threads.
    virtual Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t) const;

    /// s = A^T (b - A x), likewise; returns the squared norm of each column of b - A x.
    virtual Eigen::Array3d normal_residual(const geom::Points& b, const geom::Points& x,
                                           geom::Points& s) const;
};

/// A change of unknowns x = B y with which the problem is better conditioned. B is square and has
/// an inverse; it is known by its products only, which must not depend on the number of threads.
class Preconditioner {
  public:
    virtual ~Preconditioner() = default;
    [[nodiscard]] virtual Eigen::Index size() const = 0;
    /// t = B^T s; returns the squared norm of each column of t.
    virtual Eigen::Array3d apply_transposed(const geom::Points& s, geom::Points& t) const = 0;
    /// d = B t + d beta, column by column.
    virtual void apply(const geom::Points& t, const Eigen::Array3d& beta,
                       geom::Points& d) const = 0;
};

struct CglsOptions {
    int max_iterations = 100;  ///< K
    double relative_residual =
        1e-10;  ///< stop at |A^T r| <= this * |A^T r| of the start, by column; B^T A^T r with B
    /// Stop, too, when a step changes no unknown by more than this; in their unit.
    double step_tolerance = 0.0;
    /// For unknowns that are scaled: by how much a change of 1 moves what they stand for, columns()
    /// x 3; step_tolerance is in that unit then. Not owned.
    const geom::Points* unknown_sizes = nullptr;
    /// Steps are those of conjugate gradients for A B; x, b and the residuals below are A's. Not
    /// owned; none: B = 1.
    const Preconditioner* preconditioner = nullptr;
    /// One step length for all three coordinates: for operators that mix them.
    bool joint = false;
    base::Progress progress;
};

/// Why it ended: the residual is below its limit (or cannot get smaller), the last step was shorter
/// than step_tolerance, or max_iterations was reached.
enum class CglsStop { Residual, StepTolerance, MaxIterations };

struct CglsResult {
    geom::Points x;
    int iterations = 0;
    double residual = 0.0;         ///< |b - A x|, Frobenius
    double normal_residual = 0.0;  ///< |A^T (b - A x)|, Frobenius
    CglsStop stop = CglsStop::Residual;
};

/// Least-squares solution of A x = b for three coordinates at once, without forming A^T A. Unless
/// they are joint, each coordinate has its own step lengths, so the answer is that of three
/// separate solves. Source: Saad, Iterative Methods for Sparse Linear Systems (2003), 8.3 (CGNR);
/// A^T r is carried on by its own recurrence, so that rows are neither written nor read in a step,
/// and made anew from x before a solve ends as converged.
/// @pre   b.rows() == a.rows(), start.rows() == a.columns(), as unknown_sizes->rows() and
///        preconditioner->size()
/// @throw InvalidArgument when a precondition fails or an option is out of range
/// Not converging is an answer, not an error: see CglsResult::stop.
CglsResult solve_cgls(const LinearOperator& a, const geom::Points& b, const geom::Points& start,
                      const CglsOptions& options = {});

}  // namespace patchwright::fit
