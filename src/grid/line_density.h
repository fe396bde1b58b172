// How many cells a size function wants on lines, and where.
#pragma once

#include "grid/line_classes.h"

#include <patchwright/grid/plan.h>

namespace patchwright::grid {

/// Cells a unit of normalised arc length, over equal bins of a class of lines.
struct LineDensity {
    std::vector<double> bins;  ///< in the direction of the class

    [[nodiscard]] double cells() const { return before(1.0, false); }
    /// Cells before a fraction of an edge's length.
    [[nodiscard]] double before(double fraction, bool reversed) const;
    /// The fraction before which there are so many cells.
    [[nodiscard]] double fraction(double cells, bool reversed) const;
};

/// The largest wish in each bin over the edges of the class and lines inside blocks.
/// @throw InvalidArgument when the function returns what is no positive number
std::vector<LineDensity> line_densities(const BlockLayout& layout, const LineClasses& classes,
                                        const SizeFunction& size);

}  // namespace patchwright::grid
