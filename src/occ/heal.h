// From what a file holds to bodies: sewing, orientation, solids.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Solids of the shape stay; loose shells and faces are sewn with the smallest tolerance that
/// leaves the fewest free edges without swallowing faces, their orientation made consistent, and
/// closed shells become outward solids. Fills the sewing figures and notices of the report.
/// @pre the shape holds faces
TopoDS_Shape heal(const TopoDS_Shape& shape, double max_tolerance_rel, ReadReport& report);

/// Only what holds faces: solids, shells and faces, in a compound when there are several.
TopoDS_Shape keep_faces(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
