// Sizes of cells that are wanted at points, from a solver's adaptation for instance.
#pragma once

#include <patchwright/geom/types.h>

#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::adapt {

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

}  // namespace patchwright::adapt
#pragma GCC visibility pop
