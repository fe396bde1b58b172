// How far a fitted level is from the reference, face by face.
#pragma once

#include "fit/loop/level_fit.h"

#include <algorithm>

namespace patchwright::fit {

struct FaceError : measure::FaceDeviation {
    /// Largest distances of chains on sides along u and along v from their features, mm.
    double curve_u = 0.0, curve_v = 0.0;
    int folded = 0;  ///< samples; looked for where the whole level is within the tolerance

    [[nodiscard]] double largest() const { return std::max({max, reverse, curve_u, curve_v}); }
};

struct LevelError {
    Distances surface, curves;
    Distances reverse;  ///< of points of the reference from the limit surface
    std::vector<FaceError> faces;
    std::vector<mesh::VertexId> at_turns;  ///< see FeatureMatch::turns
};

/// On a grid over all faces, borders included and denser than the one that was fitted.
/// @param points  of the reference, to be looked for on the limit surface
LevelError measure(const mesh::Cage& cage, const LevelFit& fitted,
                   const geom::ReferenceSurface& reference, const std::vector<geom::Vec3>& points,
                   const FitOptions& options);

}  // namespace patchwright::fit
