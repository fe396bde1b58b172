// What is around the triangles that seed foot points.
#pragma once

#include "occ/foot/curve_search.h"
#include "occ/foot/reference_mesh.h"

#include <vector>

namespace patchwright::occ {

/// By the slots of the mesh's tree.
/// @param edges  all edges of the model
std::vector<Surroundings> look_around(const ReferenceMesh& mesh,
                                      const std::vector<FaceSurface>& surfaces,
                                      const CurveSearch& edges);

}  // namespace patchwright::occ
