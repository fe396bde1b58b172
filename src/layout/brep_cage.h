// A cage of blocks along the faces of a model.
#pragma once

#include "layout/blocks.h"

#include <patchwright/layout/make_cage.h>
#include <patchwright/occ/surface_mesh.h>

#include <string>
#include <vector>

namespace patchwright::layout {

struct BrepCage {
    std::vector<Blocks> parts;  ///< one a body
    std::string refused;        ///< why there are none; empty: there are
};

/// Faces become blocks, smooth neighbours of the same curvature one; see brep_layout().
/// @param surface  of the model, fine
BrepCage brep_parts(const occ::SurfaceMesh& surface, const geom::ModelSurface& reference,
                    const std::vector<std::string>& face_names, const CageOptions& options);

}  // namespace patchwright::layout
