// Cages as Python sees them.
#pragma once

#include "arrays.h"

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_mask.h>

#include <memory>

namespace patchwright::python {

/// A cage whose points are an array that Python may change in place.
class PyCage {
  public:
    explicit PyCage(mesh::Cage cage);
    /// With the memory of `points`, n x 3, which is not copied.
    /// @throw UsageError when these are not as many as the topology has vertices
    PyCage(std::shared_ptr<const mesh::Topology> topology, const Doubles& points);

    /// A copy that calls use while other threads may change the points.
    /// @throw UsageError when Python has left points that are not finite
    [[nodiscard]] mesh::Cage checked() const;
    [[nodiscard]] const mesh::Topology& topology() const { return *topology_; }
    [[nodiscard]] const std::shared_ptr<const mesh::Topology>& shared_topology() const {
        return topology_;
    }
    /// A view of the points' memory, which it keeps.
    [[nodiscard]] Doubles points() const;
    /// The same connectivity, and what is made of it, with other points, which are not copied.
    [[nodiscard]] PyCage with_points(const Doubles& points) const;
    /// Made once.
    [[nodiscard]] std::shared_ptr<const subd::LimitEvaluator> evaluator();

  private:
    std::shared_ptr<const mesh::Topology> topology_;
    Doubles points_;  // a view of its own: callers may change the shape of theirs
    std::shared_ptr<const subd::LimitEvaluator> evaluator_;
};

void bind_cage(py::module_& module);

}  // namespace patchwright::python
