// The box that a shape really fills.
#pragma once

#include <patchwright/geom/types.h>

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Smallest box around the edges and the trimmed faces, to about 1e-8 of its size for surfaces that
/// turn no more than once between two neighbouring samples. Tolerances are not added.
/// The kernel's quick box holds control points and the parts that are trimmed away (factor 6 on a
/// real file), its optimal one takes seconds.
geom::Box3 tight_bounds(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
