// What is known of the surroundings of a foot, so that a search need not look there.
#pragma once

#include "occ/foot/leaf_bounds.h"
#include "occ/foot/reference_mesh.h"

#include <vector>

namespace patchwright::occ {

/// Up to this part of the radius of curvature the distance is convex along the surface, with a
/// margin for what samples of the curvature have missed.
constexpr double convex_share = 0.7;

/// A local minimum on a face, found from a triangle.
struct SurfaceFoot {
    int face, slot;  ///< slot: where the descent began; -1: beside an edge
    FaceSurface::Foot foot;
};

/// By the end of its face: perhaps no local minimum of the surface beyond.
inline bool is_held(const SurfaceFoot& f) { return f.foot.held[0] != 0 || f.foot.held[1] != 0; }

/// The foot lies in its triangle, where the face's trim leaves out nothing.
/// @pre the foot has a slot, here and below
bool is_clear_of_trim(const ReferenceMesh& mesh, const SurfaceFoot& f);

/// Beside a foot the face bends too little towards the query for this triangle to come any nearer.
bool holds_none_nearer_than(const ReferenceMesh& mesh, const geom::Vec3& query,
                            const SurfaceFoot& f, int slot);

/// Nothing is as near as the foot but triangles beside it, where the face bends too little: what
/// edges there are, are not nearer either.
/// @param passed  all leaves with triangles within `limit`
/// @param limit   the foot's distance and a little more
bool is_alone(const ReferenceMesh& mesh, const geom::Vec3& query, const SurfaceFoot& f,
              const std::vector<PassedLeaf>& passed, double limit);

}  // namespace patchwright::occ
