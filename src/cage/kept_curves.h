// Which feature curves a cage keeps as lines.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

enum class Lines { OfTriangles, OfBlocks };

/// Curves that cages keep as lines: all sharp and free ones, and smooth ones along edges that are
/// rounded too tightly for faces of a cage, as those of blades are; in cages from triangles also
/// smooth ones at which the normal turns by a few degrees.
/// @return one entry a curve
std::vector<char> kept_curves(const geom::ModelSurface& reference, Lines lines, Poll& poll);

/// Adds smooth curves that go on where a kept one ends within the surface, as far as to another
/// kept one: blocks beside a line that ends are hard to find. What leads nowhere is left out.
void keep_continuations(const geom::ModelSurface& reference, std::vector<char>& kept);

}  // namespace patchwright::cage
