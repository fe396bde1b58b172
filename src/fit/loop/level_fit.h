// The fit on one level of refinement.
#pragma once

#include "fit/match/feature_match.h"
#include "measure/limit_deviation.h"

#include <patchwright/fit/fit.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace patchwright::fit {

using measure::Distances;

inline std::optional<geom::Vec3> unit_or_none(const geom::Vec3& v) {
    const double norm = v.norm();
    if (norm > 0.0) return geom::Vec3(v / norm);
    return std::nullopt;
}

struct LevelFit {
    geom::Points points;
    CurveSampling curves;
    FeatureMatch match;
    std::optional<int> symmetry_axis;
    bool stopped_by_time_limit = false;  ///< points are as they were after the last step
};

/// The control points as they are.
LevelFit given_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                     const FitOptions& options);

/// What is known when a level begins.
struct LevelStart {
    double foot_reach = std::numeric_limits<double>::infinity();  ///< see oriented_foot_point
    std::vector<char> folded;  ///< one a face: whether its parent was; or empty
    bool refined = false;      ///< the level before was fitted: curves move little
};

/// Control points whose limit surface is near the reference: rounds of projecting samples and
/// solving, until they have converged or improve no longer. Counts them in `level`.
/// @param points  of the reference, whose distances from the limit surface are minimised as well
/// @throw what options.progress throws, but for base::TimeLimitReached during the steps
LevelFit fit_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                   const std::vector<geom::Vec3>& points, const FitOptions& options,
                   const LevelStart& start, FitLevel& level);

}  // namespace patchwright::fit
