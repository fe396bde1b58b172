// Where points are along a line, as shares of its length.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::cage {

/// Shares of a line's length at its points, from 0 to 1.
std::vector<double> shares_of(const std::vector<geom::Vec3>& points);

/// `count` + 1 shares of a line's length, closer to each other where it bends: half of them, or
/// fewer on lines that bend little, are spread by turn instead of length.
std::vector<double> graded_shares(const std::vector<geom::Vec3>& line, int count);

/// `count` + 1 shares at equal steps.
std::vector<double> even_shares(int count);

/// Points at these shares of a line's length.
std::vector<geom::Vec3> resampled(const std::vector<geom::Vec3>& line,
                                  const std::vector<double>& at_shares);

}  // namespace patchwright::cage
