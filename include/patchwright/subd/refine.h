// One Catmull-Clark step as topology and sparse matrix.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/stencils.h>

#include <memory>

#pragma GCC visibility push(default)
namespace patchwright::subd {

/// Vertices of the fine mesh: one a coarse vertex, then one a coarse edge, then one a coarse face,
/// each in coarse order. Faces: for each coarse face one a corner, in order. Child i of a quad
/// keeps the parent's axes (its corner i is the parent's vertex i); child i of another polygon
/// starts at the parent's vertex i.
struct Refinement {
    std::shared_ptr<const mesh::Topology> topology;
    Stencils stencils;  ///< fine vertices x coarse vertices; rows sum to 1
};

/// Catmull-Clark with creases, corners, darts, boundaries and semi-sharp features.
/// Source: Catmull, Clark (1978); DeRose, Kass, Truong, Subdivision Surfaces in Character Animation
/// (1998), sections 3 and 4; blending at a vertex as in OpenSubdiv (mean of the sharpnesses that
/// end). The limit surface stays; with CreaseRule::ParabolicRunout only nearly so at corners, and
/// where lines with a runout lie beside others without.
Refinement refine(const mesh::Topology& topology);

/// @pre levels >= 0
mesh::Cage refine(const mesh::Cage& cage, int levels);

}  // namespace patchwright::subd
#pragma GCC visibility pop
