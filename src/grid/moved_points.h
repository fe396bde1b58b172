// Points at places that a plan holds for them.
#pragma once

#include <patchwright/grid/evaluate.h>
#include <patchwright/subd/ring.h>

namespace patchwright::grid {

/// Evaluates all points of a block of a smoothed plan.
void evaluate_moved(const Plan& plan, int block, subd::RingTable& table, BlockPoints& points);

/// Evaluates the points of the edges of a smoothed plan anew.
void evaluate_moved_edges(Plan& plan);

}  // namespace patchwright::grid
