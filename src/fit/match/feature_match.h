// Which feature curves and corners of the reference the sharp edges of a cage belong to.
#pragma once

#include "fit/loop/sampling.h"

#include <patchwright/geom/reference_surface.h>

#include <functional>
#include <vector>

namespace patchwright::fit {

/// Pieces of feature curves that follow each other from one end of a chain to the other; empty:
/// the chain belongs to no feature.
struct FeaturePiece {
    int curve = -1;
    geom::ArcRange range;
    bool reversed = false;  ///< the chain runs from range.to to range.from
};
using FeaturePath = std::vector<FeaturePiece>;

/// A vertex with a fixed limit point, and where that belongs: at a corner of the reference, or at a
/// point of the curve where a chain ends on one that has no corner there.
struct VertexTarget {
    mesh::VertexId vertex;
    geom::Vec3 point;
};

/// A vertex on a chain, and where on the curve its limit point belongs.
struct CurveTarget {
    mesh::VertexId vertex;
    int chain;
    geom::Vec3 point;
};

struct FeatureMatch {
    std::vector<FeaturePath> paths;  ///< one a chain
    std::vector<VertexTarget> corners;
    /// Ends of creases within the surface, at ends of curves; without those for which no curve ends
    /// as near as the next vertex, or half the chain.
    std::vector<CurveTarget> darts;
    /// Extraordinary vertices where the curve turns sharply for the edges beside them, as where a
    /// leading edge meets a wall: more or fewer faces have room there than where it is straight.
    std::vector<CurveTarget> turns;
};

/// Corners go to corners of the reference one to one, with the least sum of squared distances. The
/// chain between two corners is moved with them and goes to the nearest sequence of curves of its
/// kind between these corners. Corners farther than `reach` and chains that are farther on average
/// than `reach`, or a tenth of their length if that is more, belong to nothing.
/// @param samples  limit points of the sites of `curves`, `samples_per_site` each
/// @param poll  called in every loop that may take long; may throw
FeatureMatch match_features(const mesh::Cage& cage, const CurveSampling& curves,
                            const geom::Points& samples, int samples_per_site,
                            const geom::ReferenceSurface& reference, double reach,
                            const std::function<void()>& poll);

/// @pre the path is not empty
geom::FeaturePoint nearest_on_path(const geom::ReferenceSurface& reference, const FeaturePath& path,
                                   const geom::Vec3& query);

}  // namespace patchwright::fit
