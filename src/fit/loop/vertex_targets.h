// Where the limit points of a cage's vertices belong on the reference.
#pragma once

#include "fit/loop/level_fit.h"

namespace patchwright::fit {

/// One row a vertex: the foot point of its limit point; of vertices on sharp edges that follow a
/// feature the nearest point of that, or the corner or end that it stands for.
/// @param matched  the cage's chains, see given_level()
geom::Points vertex_targets(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                            const LevelFit& matched);

}  // namespace patchwright::fit
