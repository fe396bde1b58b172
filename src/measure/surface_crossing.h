// Where different surfaces of a list cross each other.
#pragma once

#include "measure/pair_search.h"

namespace patchwright::measure {

/// Pairs of spans of different surfaces whose boxes are near each other.
std::vector<PairTask> crossing_tasks(const PairSearch::Surfaces& surfaces);

/// Surfaces may meet along their sides, and reach into each other by less than the resolution.
SurfacePieces::Outcome test_crossing(const SurfacePieces& first, const SurfacePieces& second,
                                     const SurfacePieces::Pair& pair, double resolution);

}  // namespace patchwright::measure
