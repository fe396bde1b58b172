// Whether the sections of a wing hold all of a body.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/wing.h"

#include <patchwright/geom/types.h>

#include <optional>

namespace patchwright::cage {

/// The place of a body that is farthest from a wing's faces where that is farther than faces
/// between sections cut corners: on a winglet, say, that stands across the span, beside the
/// sections or between two of them.
/// @param body    one with triangles
/// @param blocks  of the wing, as wing_blocks() makes them
std::optional<geom::Vec3> part_left_out(const SurfaceBody& body, const Wing& wing,
                                        const Blocks& blocks, Poll& poll);

}  // namespace patchwright::cage
