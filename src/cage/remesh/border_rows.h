// Rows of quads along the borders of regions.
#pragma once

#include "cage/remesh/polygon_mesh.h"

namespace patchwright::cage {

/// Puts a row of quads between the border of a region and its polygons, where that costs less than
/// its triangles do. A vertex inside a feature curve needs two faces in the region, and so cannot
/// be part of every merged quad; the vertices of the row can.
/// @return whether there are any
bool add_border_rows(PolygonMesh& polygons);

}  // namespace patchwright::cage
