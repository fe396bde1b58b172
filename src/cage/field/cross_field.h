// Four directions at right angles on every triangle of a mesh, along its features and smooth.
#pragma once

#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// What a cross should be near to.
struct FieldHint {
    geom::Vec3 direction = geom::Vec3::Zero();
    double weight = 0.0;  ///< against the smoothness between neighbours, which counts about 1
};

struct CrossField {
    /// One a triangle: one of the four directions, a unit vector in the triangle's plane; zero for
    /// triangles that are gone.
    std::vector<geom::Vec3> direction;
};

/// Principal directions of the surface, one a triangle; weights by how much its two curvatures
/// differ.
std::vector<FieldHint> curvature_hints(const geom::EditableMesh& mesh,
                                       const geom::ModelSurface& reference, Poll& poll);

/// Splits inner edges between two vertices on features or boundaries, so that no triangle touches
/// two of these, and those opposite to a vertex where a border turns away or a feature ends, so
/// that enough triangles are there for the field to turn.
void open_corners(geom::EditableMesh& mesh);

/// The smoothest crosses that lie along features and boundaries; hints pull at them a little.
/// Source: Knoeppel et al., Globally optimal direction fields (2013), by triangles; Viertel and
/// Osting, An approach to quad meshing based on harmonic cross-valued maps (2019), for the steps of
/// diffusion with renormalisation.
/// @param mesh   no triangle with two sides on features; see open_corners()
/// @param hints  one a triangle, or none at all
CrossField cross_field(const geom::EditableMesh& mesh, const std::vector<FieldHint>& hints,
                       Poll& poll);

/// Weight of a difference between the triangles on both sides of side k of a triangle, in a sum of
/// squares that is Dirichlet's energy.
/// @pre the side is not on the boundary
double side_weight(const geom::EditableMesh& mesh, int t, int k);

/// How much a field turns between neighbouring triangles, radians in (-pi/4, pi/4], against a
/// direction that is carried straight across the edge.
double field_turn(const geom::EditableMesh& mesh, const CrossField& field, int from, int to);

}  // namespace patchwright::cage
