// The cells of a plan as the roots of a forest.
#pragma once

#include "adapt/quad_forest.h"

#include <patchwright/grid/plan.h>

#include <vector>

namespace patchwright::adapt {

struct PlanForest {
    QuadForest forest;
    geom::Points points;     ///< of the plan, bit by bit
    std::int32_t roots = 0;  ///< the first quads
};

/// Points and edges that blocks share are there once. Quads block by block, i fastest.
PlanForest forest_of_plan(const grid::Plan& plan);

}  // namespace patchwright::adapt
