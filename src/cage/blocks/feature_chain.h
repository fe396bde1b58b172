// Feature curves one after another.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

struct FeatureChain {
    std::vector<int> curves;
    bool closed = false;  ///< the last one ends where the first one begins
};

/// A curve and those after it: at each place the sharp or smooth curve that leads straight on.
/// @param backwards  on from the curve's start, not from its end
FeatureChain chain_from(int curve, bool backwards, const geom::ModelSurface& reference);

}  // namespace patchwright::cage
