// Sizes of cells that are wanted at points, from a solver's adaptation for instance.
#pragma once

#include <patchwright/grid/plan.h>

#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// A size everywhere: that of the nearest point.
class SizeField {
  public:
    /// @param at  one row a size
    /// @throw InvalidArgument when there are none, numbers differ, or a size is not positive
    SizeField(geom::Points at, std::vector<double> sizes_mm);

    [[nodiscard]] double operator()(const geom::Vec3& p) const;

  private:
    struct State;
    std::shared_ptr<const State> state_;
};

/// Halves cells along whole lines until no cell's side is longer than the size at its middle, or
/// for so many rounds; spacing laws are kept in between.
/// @throw UsageError when the grid would not fit into memory
Plan refined(const Plan& plan, const SizeField& sizes, int max_rounds = 20);

}  // namespace patchwright::grid
#pragma GCC visibility pop
