// How many edges the lines of a block layout are to get.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

struct ArcSizes {
    double tolerance_rel = 1e-3;  ///< of the diagonal: what the cage is to be fitted to
    double largest_rel = 0.3;     ///< of the diagonal: longest edge
    double fineness = 1.0;        ///< divides lengths by curvature
    double scale = 1.0;           ///< times all lengths
};

/// Raises LayoutArc::least: loops need several edges, and so do arcs between the same two nodes but
/// for the shortest one.
void set_least(QuadLayout& layout);

/// Sets LayoutArc::wanted and LayoutArc::least: by length and curvature of the arcs and of lines
/// through their blocks, so that what bends inside a block only is not missed.
void set_wanted(QuadLayout& layout, const geom::ModelSurface& reference, const ArcSizes& sizes,
                Poll& poll);

}  // namespace patchwright::cage
