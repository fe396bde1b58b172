// Graded distances between the lines of a cage.
#pragma once

#include <patchwright/mesh/cage.h>

#include <vector>

namespace patchwright::fit {

/// Spreads the jumps of spacing that splitting single strips leaves: moves control points along
/// the lines of the cage until the lengths of neighbouring edges of a line have changed, against
/// those before the split, by no more than a ratio of 1.3 between them. Corners, extraordinary
/// vertices inside the surface, ends of creases and pinned vertices stay.
/// @param halvings  one an edge: how often it was halved; edges halved more than once are to stay
///                  as short as they are
/// @param held      other vertices that are to stay
void grade_spacing(mesh::Cage& cage, const std::vector<int>& halvings,
                   const std::vector<mesh::VertexId>& held = {});

}  // namespace patchwright::fit
