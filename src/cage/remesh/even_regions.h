// Regions between features with an odd number of triangles, in twos.
#pragma once

#include "cage/poll.h"
#include "cage/remesh/polygon_mesh.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

/// A region whose border has an odd number of edges keeps a triangle whatever its inner edges are.
/// Splits the feature edges that the shortest way from its triangles to those of another such
/// region crosses: then each region on the way has an even number of triangles to merge.
void make_regions_even(PolygonMesh& polygons, const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
