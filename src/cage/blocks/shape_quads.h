// Points of quads are moved within the model to where the quads have good shapes.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <utility>
#include <vector>

namespace patchwright::cage {

/// Where a point may go.
struct Freedom {
    bool free = true;  ///< anywhere on the surface
    int curve = -1;    ///< if not free: along this feature; -1: along the line, if any
    /// If neither: a unit vector, along which the point may go on the surface; zero: nowhere.
    geom::Vec3 line = geom::Vec3::Zero();

    [[nodiscard]] bool on_line() const { return !free && curve < 0 && !line.isZero(); }
    [[nodiscard]] bool on_surface() const { return free || on_line(); }
    [[nodiscard]] bool moves() const { return on_surface() || curve >= 0; }
};

/// Quads whose points are on a model.
struct QuadsOnModel {
    const std::vector<std::vector<int>>& faces;       ///< four points each
    const std::vector<Freedom>& freedom;              ///< one a point
    const std::vector<std::pair<int, int>>& creases;  ///< pairs of points; quads on either side
                                                      ///< need not be of like lengths
    const std::vector<geom::Vec3>& normals;           ///< unit, of the model at each quad
};

/// Moves points so that angles of quads come near 90 degrees and lengths of edges change little
/// from quad to quad, and opens quads that fold: least regularised distortion (Garanzha, Kaporin,
/// Kudryavtseva, Protais, Ray and Sokolov, "Foldover-free maps in 50 lines of code", 2021), one
/// point after the other by Newton's method. Where quads are larger than the model's radii of
/// curvature some may stay folded. Points that are not free stay while no quad around them has a
/// small angle or one near 180 degrees.
/// @param points  on the model; moved
void shape_quads(const QuadsOnModel& quads, std::vector<geom::Vec3>& points,
                 const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
