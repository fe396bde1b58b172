// Sparse rows of coefficients over control points: subdivision matrices and masks.
#pragma once

#include <patchwright/geom/types.h>

#include <cstdint>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::subd {

/// A sparse matrix in compressed rows; row i makes the i-th fine point from the coarse points.
struct Stencils {
    int columns = 0;
    std::vector<std::int64_t> begin{0};  ///< rows + 1
    std::vector<std::int32_t> index;     ///< coarse vertex of each entry; unique within a row
    std::vector<double> weight;

    [[nodiscard]] int rows() const { return static_cast<int>(begin.size()) - 1; }
    /// @pre coarse.rows() == columns
    [[nodiscard]] geom::Points apply(const geom::Points& coarse) const;
    /// Indices of a row rise.
    [[nodiscard]] Stencils transposed() const;
};

/// The product `fine` * `coarse`: from the coarsest points to the finest in one step. Indices of a
/// row rise.
/// @pre  fine.columns == coarse.rows()
Stencils multiply(const Stencils& fine, const Stencils& coarse);

/// One row under construction; adding to an index twice sums up.
class StencilRow {
  public:
    void add(std::int32_t index, double weight);
    /// this += factor * other
    void add(const StencilRow& other, double factor);
    /// Appends the row to the matrix and empties it.
    void flush(Stencils& to);

  private:
    std::vector<std::pair<std::int32_t, double>> entries_;
};

}  // namespace patchwright::subd
#pragma GCC visibility pop
