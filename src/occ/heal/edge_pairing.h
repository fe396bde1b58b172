// Edges in one place: which faces belong together there.
#pragma once

#include "occ/exchange/face_origins.h"

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Where four faces meet in one place, as thin strips do that end at each other, sewing makes two
/// edges and joins the faces as they come. Where the sides of the faces, as known from their other
/// neighbours, contradict that, the faces are joined the other way round. Two edges are in one
/// place when they have common vertices, mid-points nearer than `tolerance`, and the same
/// parameters.
/// @return number of pairs of edges changed
int pair_coincident_edges(TopoDS_Shape& shape, double tolerance, FaceOrigins& origins);

}  // namespace patchwright::occ
