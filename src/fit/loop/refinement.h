// Where a cage is refined, and how.
#pragma once

#include "fit/loop/measure.h"

#include <patchwright/mesh/cage.h>

namespace patchwright::fit {

/// Of each face: what its parent was like, and how often splitting gained too little.
struct FaceHistory {
    double parent = std::numeric_limits<double>::infinity();
    int cuts = 0;         ///< in a row that gained too little
    bool folded = false;  ///< the parent was
};

/// The next level's cage, near the limit surface of this one.
struct NextLevel {
    mesh::Cage cage;
    std::vector<FaceHistory> history;
    bool local = false;
};

/// Splits the chords that cross faces beyond the tolerance in the direction in which their distance
/// changes; or all faces, where most would be split, where faces are not quads, or on request.
/// Strips along features narrower than faces are halved again, as far as the cage may grow.
/// @param most_faces  that the next cage may have
/// @return nothing when no face that may gain is beyond the tolerance, when all would be split for
///         the sake of too few, or the cage would grow beyond options.max_vertices or most_faces
std::optional<NextLevel> refine_where_needed(
    const mesh::Cage& cage, const LevelError& error, std::vector<FaceHistory> history,
    const FitOptions& options, RefinementScope refinement,
    double most_faces = std::numeric_limits<double>::infinity());

}  // namespace patchwright::fit
