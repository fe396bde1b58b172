// The plane that a half model ends on.
#pragma once

#include "fit/match/feature_match.h"
#include "fit/solve/constraints.h"

#include <patchwright/fit/fit.h>

#include <optional>

namespace patchwright::fit {

struct SymmetryPlane {
    int axis = 0;               ///< the plane is this coordinate = 0
    std::vector<int> vertices;  ///< control points on it
    /// See PointConstraints::followers: where the reference meets the plane at right angles.
    std::vector<PointConstraints::Follower> followers;
};

/// The plane x, y or z = 0 on which chains of the cage end with the reference, which lies on one
/// side of it.
/// @throw InvalidArgument when the plane that is asked for has no chain on it
std::optional<SymmetryPlane> find_symmetry(const mesh::Topology& topology,
                                           const geom::Points& points, const CurveSampling& curves,
                                           const FeatureMatch& match,
                                           const geom::ReferenceSurface& reference,
                                           const FitOptions& options);

}  // namespace patchwright::fit
