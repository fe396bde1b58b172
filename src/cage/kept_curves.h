// Which feature curves a cage keeps as lines.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

enum class Lines { OfTriangles, OfBlocks };

/// Curves that cages keep as lines: all sharp and free ones, and smooth ones along edges that are
/// rounded too tightly for faces of a cage, as those of blades are. In cages from blocks also bends
/// that need a crease, between faces as wide as the curve is long at most; in cages from triangles
/// smooth ones at which the normal turns by a few degrees.
/// @param tolerance_mm  what the cage is to be fitted to
/// @return one entry a curve
std::vector<char> kept_curves(const geom::ModelSurface& reference, Lines lines, double tolerance_mm,
                              Poll& poll);

/// Adds smooth curves that go on where a kept one ends within the surface, as far as to another
/// kept one: blocks beside a line that ends are hard to find. What leads nowhere is left out.
void keep_continuations(const geom::ModelSurface& reference, std::vector<char>& kept);

}  // namespace patchwright::cage
