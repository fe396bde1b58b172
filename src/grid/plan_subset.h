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

/// Which points of a line a grid of about half as many cells keeps: the same from both ends.
std::vector<int> every_second(int cells);
KeptPoints every_second(const Plan& plan);

/// Where a point of a line lies between two of those that a coarser one keeps.
struct Between {
    int first;
    double share;
};
std::vector<Between> between(const std::vector<int>& kept);

}  // namespace patchwright::grid
