// Triangles that the kernel left too far from their faces.
#pragma once

#include "occ/foot/reference_mesh.h"

#include <vector>

namespace patchwright::occ {

/// Divides triangles that lie much farther off their faces than was asked for, as the kernel leaves
/// them beside edges and vertices of large tolerance: searches would find candidates everywhere.
/// Neighbours that stay as they are keep their whole sides.
/// @param deflection  millimetres
void divide_coarse_triangles(ReferenceMesh& mesh, const std::vector<FaceSurface>& surfaces,
                             double deflection);

}  // namespace patchwright::occ
