// Cages as Python sees them.
#pragma once

#include "arrays.h"

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_mask.h>

#include <memory>

namespace patchwright::python {

/// A cage whose points Python may change in place.
class PyCage {
  public:
    explicit PyCage(mesh::Cage cage) : cage_(std::move(cage)) {}

    /// @throw UsageError when Python has left points that are not finite
    [[nodiscard]] mesh::Cage checked() const;
    [[nodiscard]] const mesh::Topology& topology() const { return *cage_.topology; }
    [[nodiscard]] geom::Points& points() { return cage_.points; }
    [[nodiscard]] const std::shared_ptr<const mesh::Topology>& shared_topology() const {
        return cage_.topology;
    }
    /// Made once; cages of one topology do not share it.
    [[nodiscard]] std::shared_ptr<const subd::LimitEvaluator> evaluator();

  private:
    mesh::Cage cage_;
    std::shared_ptr<const subd::LimitEvaluator> evaluator_;
};

void bind_cage(py::module_& module);

}  // namespace patchwright::python
