// Concave corners and prescribed normals.
#pragma once

#include <patchwright/mesh/cage.h>

namespace patchwright::subd {

/// Moves control points next to the cage's tagged sectors (see mesh::SectorTagInput) so that the
/// limit surface has a tangent plane there, at right angles to the tag's normal if there is one. In
/// a sector with an angle, what would shrink by less than half at every step, and fold the surface
/// at concave corners, is taken out of the points around the vertex; a normal moves them by the
/// least that it takes, and never the vertex itself.
/// Source: Biermann, Levin, Zorin, Piecewise smooth subdivision surfaces with normal control
/// (2000). They apply the correction at every step; here it is made once, on the control points, so
/// that the rules stay linear and as local as the ordinary ones.
/// @throw InputError when the faces of a tagged sector are no quads (subdivide once), or when the
///        vertex has no tangent plane to turn
mesh::Cage control_normals(const mesh::Cage& cage);

}  // namespace patchwright::subd
