// Index ranges in which blocks meet.
#pragma once

#include <patchwright/grid/plan.h>

namespace patchwright::grid {

/// Corresponding points of two blocks, 0-based; the first range rises.
struct Interface {
    int block = -1, donor = -1;
    std::array<int, 2> begin{}, end{}, donor_begin{}, donor_end{};
    /// Component k: which index of the donor, 1 or 2, goes with index k, negative when it falls.
    std::array<int, 2> transform{};
};

/// Where a block's surface ends.
struct FreeSide {
    int block = -1;
    std::array<int, 2> begin{}, end{};
};

struct Interfaces {
    std::vector<Interface> connections;  ///< each from both sides
    std::vector<FreeSide> free;
};

Interfaces find_interfaces(const Plan& plan);

}  // namespace patchwright::grid
