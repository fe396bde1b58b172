// How well neighbouring patches meet.
#pragma once

#include <patchwright/geom/types.h>

#pragma GCC visibility push(default)
namespace patchwright::patch {

/// How neighbouring faces meet along their shared edges, measured on both surfaces.
struct Continuity {
    double max_gap_mm = 0.0;  ///< largest distance between the two surfaces at one edge parameter
    geom::Vec3 gap_at = geom::Vec3::Zero();
    /// Largest angle between the normals over edges that are no creases, farther from vertices
    /// without a tangent plane than the distance that was asked for.
    double max_kink_rad = 0.0;
    geom::Vec3 kink_at = geom::Vec3::Zero();
    /// The same nearer to such vertices.
    double near_singular_kink_rad = 0.0;
    geom::Vec3 near_singular_kink_at = geom::Vec3::Zero();
    int crease_edges = 0;  ///< edges recognised as creases
    int smooth_edges = 0;
};

}  // namespace patchwright::patch
#pragma GCC visibility pop
