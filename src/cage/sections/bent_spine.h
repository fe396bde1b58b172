// Spines of wings that bend, such as into winglets.
#pragma once

#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/geom/model_surface.h>

#include <optional>
#include <set>

namespace patchwright::cage {

struct BentSpine {
    Spine spine;
    std::set<int> tail;  ///< curves of the trailing edge that it follows
};

/// A fan of planes across the way that the trailing edge takes, seen along the chord: nothing where
/// there is no trailing edge across `axis`, where it hardly bends or where it does not run from one
/// end of the body to the other.
std::optional<BentSpine> bent_spine(const SurfaceBody& body, const geom::ModelSurface& reference,
                                    const geom::Vec3& axis, Poll& poll);

}  // namespace patchwright::cage
