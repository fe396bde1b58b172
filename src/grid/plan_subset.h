// Plans of some of another plan's points.
#pragma once

#include <patchwright/grid/plan.h>

namespace patchwright::grid {

/// Per edge which of its points stay, rising; ends do.
using KeptPoints = std::vector<std::vector<int>>;

/// @pre edges that must match keep the same ones
Plan subset(const Plan& plan, const KeptPoints& kept);

/// Of a block's points along side 0 or 1.
std::vector<int> kept_along(const BlockLayout& layout, const KeptPoints& kept, int block,
                            std::size_t side);

}  // namespace patchwright::grid
