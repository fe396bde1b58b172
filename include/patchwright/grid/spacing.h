// How the points of a grid line are spread along it.
#pragma once

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::grid {

enum class Law {
    Uniform,
    Geometric,  ///< cells grow by one factor away from the ends whose size is given
    Tanh,       ///< hyperbolic tangent, one- or two-sided as sizes are given
    Cosine      ///< (1 - cos(pi x)) / 2; where one end only is dense 1 - cos(pi x / 2)
};

/// Which ends of a line are dense. Sizes are those of the first and the last cell, as shares of the
/// whole line; 0: free. Uniform ignores them, Cosine asks only which are not 0 (both or none: both
/// ends are dense), the others are uniform when both are free.
struct EndSizes {
    double first = 0.0;
    double last = 0.0;
};

/// Fractions of a line, rising, from exactly 0 to exactly 1. Sizes that are given are met, also
/// larger ones than the uniform; Geometric with two sizes so unlike that one factor cannot join
/// them meets the smaller one.
/// Source: Vinokur, On one-dimensional stretching functions for finite-difference calculations
/// (1983); its two parameters are solved for the sizes of cells in place of slopes.
/// @return cells + 1 values
/// @throw InvalidArgument when there are no cells or a size is not in [0, 1)
std::vector<double> fractions(Law law, int cells, const EndSizes& sizes = {});

}  // namespace patchwright::grid
#pragma GCC visibility pop
