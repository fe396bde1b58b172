// Places on a cage by the million, and what is written of them.
#pragma once

#include "command.h"
#include "table.h"

#include <patchwright/subd/limit_mask.h>

#include <string>
#include <vector>

namespace patchwright::cli {

/// Files of `eval`; empty where not asked for.
struct EvalFiles {
    std::string at_file, output, jacobian, gradient, adjoint;
};

/// Places as arrays.
class Places {
  public:
    void add(const subd::Location& at);
    /// Adds one a line: FACE,U,V or FACE,U,V,SECTOR.
    /// @throw InputError naming the line that is no place on the mesh
    void read(const std::string& file, const mesh::Topology& topology);
    /// Adds the place that a row begins with.
    /// @throw InputError naming the line of what is no place on the mesh
    void add(const Table& table, std::size_t i, bool has_sector, const mesh::Topology& topology);

    [[nodiscard]] subd::Locations locations() const { return {faces_, uv_, sectors_}; }

  private:
    std::vector<std::int32_t> faces_;
    std::vector<double> uv_;
    std::vector<std::int32_t> sectors_;
};

/// Adds what is asked for to the run's outputs, and names the stages.
/// @return  a line a file
/// @throw InputError when gradients are not one a place
std::string write_eval_files(Run& run, const mesh::Cage& cage,
                             const subd::LimitEvaluator& evaluator, const Places& places,
                             const EvalFiles& files);

}  // namespace patchwright::cli
