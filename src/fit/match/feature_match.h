// Which feature curves and corners of the reference the sharp edges of a cage belong to.
#pragma once

#include "fit/loop/sampling.h"

#include <patchwright/geom/reference_surface.h>

#include <vector>

namespace patchwright::fit {

/// Pieces of feature curves that follow each other from one end of a chain to the other; empty:
/// the chain belongs to no feature.
struct FeaturePiece {
    int curve = -1;
    geom::ArcRange range;
};
using FeaturePath = std::vector<FeaturePiece>;

struct FeatureMatch {
    std::vector<FeaturePath> paths;  ///< one a chain
    /// Vertices with a fixed limit point that have their place: corners of the reference, or points
    /// of the curve where a chain ends on one that has no corner there.
    struct Place {
        mesh::VertexId vertex;
        geom::Vec3 point;
    };
    std::vector<Place> places;
    /// An end of a crease within the surface, and where its limit point belongs: the end of a
    /// curve. Darts that have none as near as the next vertex, or half the chain, are left out.
    struct Dart {
        mesh::VertexId vertex;
        int chain;
        geom::Vec3 point;
    };
    std::vector<Dart> darts;
};

/// Corners go to corners of the reference one to one, with the least sum of squared distances; a
/// chain goes to the sequence of curves of its kind between its corners that it is nearest to, once
/// it is moved along with its ends. Corners farther than `reach` and chains that are farther on
/// average than `reach`, or a tenth of their length if that is more, belong to nothing.
/// @param samples  limit points of the sites of `curves`, `samples_per_site` each
FeatureMatch match_features(const mesh::Topology& topology, const geom::Points& points,
                            const CurveSampling& curves, const geom::Points& samples,
                            int samples_per_site, const geom::ReferenceSurface& reference,
                            double reach);

/// @pre the path is not empty
geom::FeaturePoint nearest_on_path(const geom::ReferenceSurface& reference, const FeaturePath& path,
                                   const geom::Vec3& query);

}  // namespace patchwright::fit
