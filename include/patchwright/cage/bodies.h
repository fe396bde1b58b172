// Which body of a model each part of a cage lies on.
#pragma once

#include <patchwright/geom/model_surface.h>
#include <patchwright/mesh/cage.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::cage {

/// For each part of a cage the body that it lies on, or else the whole model. A part lies on a body
/// when none of its vertices is farther from that body than from the whole model by more than 0.2 %
/// of the diagonal: vertices of a cage need not lie on the surface.
/// @param parts  as mesh::connected_parts gives them
std::vector<const geom::ReferenceSurface*> references_of_parts(
    const std::vector<mesh::Cage>& parts, const std::vector<geom::BodyReference>& bodies,
    const geom::ModelSurface& whole);

}  // namespace patchwright::cage
#pragma GCC visibility pop
