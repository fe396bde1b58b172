// Where a cage is refined, and how.
#pragma once

#include "fit/loop/measure.h"

#include <patchwright/mesh/cage.h>

namespace patchwright::fit {

/// What is remembered of each face: how far its parent was, and how often splitting did not help.
struct FaceHistory {
    double parent = std::numeric_limits<double>::infinity();
    int cuts = 0;  ///< that did not bring the face nearer, one after the other
};

/// The next level's cage, near the limit surface of this one.
struct NextLevel {
    mesh::Cage cage;
    std::vector<FaceHistory> history;
    bool local = false;
};

/// Chords that cross faces beyond the tolerance, in the direction in which their distance changes,
/// are split; all faces are where most would be, where faces are not quads, and where asked for.
/// @return nothing when no face that may gain is beyond the tolerance, or the cage would grow
///         beyond options.max_vertices
std::optional<NextLevel> refine_where_needed(const mesh::Cage& cage, const LevelError& error,
                                             std::vector<FaceHistory> history,
                                             const FitOptions& options, Refinement refinement);

}  // namespace patchwright::fit
