// Triangles of all faces of a shape, glued along their edges.
#pragma once

#include "occ/foot/foot_point_engine.h"

#include <patchwright/geom/surface_mesh.h>
#include <patchwright/occ/cad_model.h>

namespace patchwright::occ {

/// @param search  of this model
/// @param deflection_mm  largest distance of a triangle from its face, as far as the kernel keeps
/// it
/// @throw InputError when nothing can be triangulated
geom::SurfaceMesh surface_mesh(const CadModel& model, const SearchModel& search,
                               double deflection_mm);

}  // namespace patchwright::occ
