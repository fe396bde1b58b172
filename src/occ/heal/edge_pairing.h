// Edges in one place: which faces belong together there.
#pragma once

#include "occ/exchange/face_origins.h"

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Where four faces meet in one place, as thin strips do that end at each other and solids that
/// touch, sewing makes two edges and joins the faces as they come. Here they are joined so that
/// none folds back onto the other, as they hang together elsewhere, and where that is open as the
/// narrowest wedges, so that solids that touch along a rim stay two. Two edges are in one place
/// when they have common vertices and are nearer than `tolerance` between them. P-curves that are
/// moved to another edge get its range, not its speed: see bring_pcurves_into_step().
/// @return number of pairs of edges changed
int pair_coincident_edges(TopoDS_Shape& shape, double tolerance, FaceOrigins& origins);

}  // namespace patchwright::occ
