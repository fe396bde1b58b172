// From what a file holds to bodies: sewing, orientation, solids.
#pragma once

#include "occ/exchange/face_origins.h"

#include <patchwright/occ/cad_model.h>

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Solids of the shape stay; from loose shells and faces duplicates and slivers are dropped, the
/// rest is sewn with a tolerance that its gaps ask for, orientation made consistent, and closed
/// shells become outward solids. Counts and describes in the report what was changed.
/// @pre the shape holds faces
/// @param size_mm  diagonal of its tight_bounds()
TopoDS_Shape heal(const TopoDS_Shape& shape, double size_mm, double max_tolerance_rel,
                  ReadReport& report, FaceOrigins& origins, const base::Progress& progress = {});

/// Only what holds faces: solids, shells and faces, in a compound when there are several.
TopoDS_Shape keep_faces(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
