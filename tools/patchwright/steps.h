// Steps of a motion: files of displacements, and names of what is written of each.
#pragma once

#include "files.h"
#include "table.h"

#include <string>
#include <string_view>
#include <vector>

namespace patchwright::cli {

/// In names of outputs: the name of a step's file of displacements, without folder and extension.
constexpr std::string_view step_placeholder = "{step}";

/// Empty where nothing is written.
struct StepOutputs {
    std::string cage, cad, grid, velocities;
};

struct StepFiles {
    std::string displacements;
    StepOutputs outputs;
};

/// @param displacements  a file a step
/// @param patterns       names with the placeholder, which one step may do without
/// @throw UsageError where steps would write the same file
std::vector<StepFiles> step_files(const std::vector<std::string>& displacements,
                                  const StepOutputs& patterns);

/// For check_files().
void add_files(RunFiles& files, const std::vector<StepFiles>& steps);

/// A structural model's points, displacements and, where there are nine columns, velocities; a
/// table a step, of the same points.
/// @throw InputError naming the line that is not so, or where the points differ
std::vector<Table> read_steps(const std::vector<StepFiles>& steps);

}  // namespace patchwright::cli
