// A quantity of a solution at points, by whose jumps a grid is refined.
#pragma once

#include <patchwright/geom/types.h>

#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::adapt {

/// A quantity everywhere, for any number of threads: linear about the nearest point, with a
/// gradient by least squares over its neighbours, and within what these have. Neighbours are the
/// nearest points and, where these lie along one line, as in stretched grids, the nearest ones
/// across it; directions that they do not span have no slope. Source: Mavriplis, Revisiting the
/// least-squares procedure for gradient reconstruction on unstructured meshes (2003): weights by
/// distance; Barth and Jespersen, The design and application of upwind schemes on unstructured
/// meshes (1989): bounds.
class Sensor {
  public:
    /// @param at  one row a value
    /// @throw InvalidArgument when there are none, numbers differ, or a value is not finite
    Sensor(geom::Points at, std::vector<double> values);

    [[nodiscard]] double operator()(const geom::Vec3& p) const;
    /// Largest value less smallest one.
    [[nodiscard]] double range() const;

  private:
    struct State;
    std::shared_ptr<const State> state_;
};

}  // namespace patchwright::adapt
#pragma GCC visibility pop
