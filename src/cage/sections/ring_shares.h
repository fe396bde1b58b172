// Where rings of a body around an axis lie.
#pragma once

#include "cage/sections/tube.h"

#include <vector>

namespace patchwright::cage {

/// Of a line: no two rings are farther from each other.
constexpr double longest_step_rel = 0.25;

/// The shares of the length of a piece at which rings lie, nearer to each other where its lines
/// bend: both ends included, but a share of 0 or 1 on the axis.
/// @param fineness  rings are nearer to each other by this factor
std::vector<double> ring_shares(const Tube& tube, int piece, double fineness);

}  // namespace patchwright::cage
