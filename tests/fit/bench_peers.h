// What the solver of the fit is compared with: stored sparse rows, Eigen, CHOLMOD.
#pragma once

#include "fit/solve/cgls.h"

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_operator.h>

#include <Eigen/SparseCore>
#include <optional>
#include <string>

namespace patchwright::bench {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// A limit operator's rows, face after face, from masks of single points.
SparseRows sparse_rows(const mesh::Cage& cage, const subd::ParameterSet& set);

/// CGLS on compressed rows with the transpose stored, as fast as it goes: three right-hand sides a
/// sweep, dot products and updates within the sweeps, vectors of AVX2 where there are. Stops as
/// fit::solve_cgls does.
class StoredRows {
  public:
    explicit StoredRows(SparseRows matrix)
        : matrix_(std::move(matrix)), transposed_(matrix_.transpose()) {}
    [[nodiscard]] const SparseRows& matrix() const { return matrix_; }
    [[nodiscard]] std::size_t bytes() const;
    [[nodiscard]] fit::CglsResult solve(const geom::Points& b, const geom::Points& start,
                                        const fit::CglsOptions& options) const;

  private:
    SparseRows matrix_, transposed_;
};

struct PeerResult {
    geom::Points x;
    double seconds = 0.0;
    int iterations = 0;
};

/// Eigen's LeastSquaresConjugateGradient with its Jacobi preconditioner, coordinate by coordinate.
/// Includes its set-up.
PeerResult solve_eigen(const SparseRows& matrix, const geom::Points& b, const geom::Points& start,
                       double relative_residual);

struct CholeskyResult {
    std::string missing;  ///< why there is no result
    geom::Points x;
    double form = 0.0, analyze = 0.0, factorize = 0.0, solve = 0.0;  ///< seconds
    double factor_gb = 0.0;
    std::string blas;
    [[nodiscard]] double seconds() const { return form + analyze + factorize + solve; }
};

/// Supernodal CHOLMOD on the normal equations, all coordinates at once.
CholeskyResult solve_cholmod(const SparseRows& matrix, const geom::Points& b);

}  // namespace patchwright::bench
