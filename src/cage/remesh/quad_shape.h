// What makes a good quad of a cage, and how many faces its vertices need.
#pragma once

#include "geom/editable_mesh.h"

#include <patchwright/geom/types.h>

#include <array>

namespace patchwright::cage {

/// Below this a quad is worse than two triangles: an angle above 166 degrees, or a fold.
constexpr double least_quad_quality = 0.15;

/// 1 for flat rectangles, 0 when an angle is 0 or 180 degrees or the quad bends by 60.
double quad_quality(const std::array<geom::Vec3, 4>& corners);

/// 1 for regular triangles, 0 when an angle is 0: the least angle over 60 degrees.
double triangle_quality(const std::array<geom::Vec3, 3>& corners);

/// The faces that a sector between two features needs at a vertex, or the whole of a vertex without
/// features: with fewer the limit surface has no proper tangent plane there.
/// @param angle_rad  of the sector
int least_faces(geom::VertexKind kind, bool on_boundary, double angle_rad);

/// 1 up to the angle that a face of several may have at a corner, 0 for 180 degrees.
double evenness(double angle_rad);

/// Whether a face's angle at a corner leaves enough of the sector to the other faces there: where
/// angles are uneven the limit surface runs over the sharp edges.
bool is_even_enough(geom::VertexKind kind, double angle_rad, double sector_angle_rad);

}  // namespace patchwright::cage
