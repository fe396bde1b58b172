// Sizes of the cells at which grid lines end.
#pragma once

#include "grid/line_classes.h"

#include <patchwright/grid/plan.h>

#include <vector>

namespace patchwright::grid {

/// Sizes of the first and last cell of an edge, along its own direction; 0: free.
struct Ends {
    double first_mm = 0.0, last_mm = 0.0;
};

/// What the options ask for where grid lines end at creases and between families.
std::vector<Ends> ends_at_borders(const BlockLayout& layout, const PlanOptions& options);

/// The same at corresponding ends of all edges that lines connect: lines between edges that are
/// dense and edges that are not would shear.
void share_ends(const LineClasses& classes, std::vector<Ends>& ends);

}  // namespace patchwright::grid
