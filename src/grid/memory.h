// Refusing grids before the memory for them is asked for.
#pragma once

#include <patchwright/grid/plan.h>

namespace patchwright::grid {

/// Of a block that is written: position, place and fields, once while it is evaluated and once
/// while it is written.
inline constexpr double block_point_bytes = 2 * (5 * sizeof(double) + 6 * sizeof(float));

/// @param points  of the whole grid, for the message
/// @throw UsageError when the process cannot have so many bytes
void require_memory(double points, double bytes);

/// For a grid of so many points along k that is written block by block.
/// @param kept_layers  of these, held for all blocks at once
void require_memory(const Plan& plan, int layers, int kept_layers);

}  // namespace patchwright::grid
