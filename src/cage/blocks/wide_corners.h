// Corners where two quads between features span more than half a turn.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// Near such a corner the limit surface runs over the features: with d1 and d2 the edges on these,
/// and e the edge between the two quads, points along e are near (e + k (d1 + d2) / 6) / 2^k after
/// k steps (decision 056). Where that is beyond the corner by more than `allowed_mm`, d1 and d2 are
/// halved, or the longer one, with the whole chords that they belong to (mesh::Chords), until it is
/// not. Chords that would halve e as well, or that another corner needs to stay, are left whole.
/// @param curves  of the edges on features; new points on these keep to them
void divide_at_wide_corners(Blocks& blocks, EdgeCurves curves, const geom::ModelSurface& reference,
                            double allowed_mm, Poll& poll);

}  // namespace patchwright::cage
