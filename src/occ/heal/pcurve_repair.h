// P-curves that do not run in step with their edge, or not along it.
#pragma once

#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Sewing joins edges of neighbours whose parameters differ; where their curves have kinks, the
/// kernel fails to bring the p-curve into step with the edge: it raises the tolerance instead (6 mm
/// on a 155 mm chord) or is off by more than its tolerance says. Such p-curves get the edge's
/// parameter, and the tolerances of their edges and vertices what is then measured. Changes the
/// shape in place.
/// @param tolerance  p-curves that keep step up to this are left alone
/// @return number of p-curves replaced
int bring_pcurves_into_step(const TopoDS_Shape& shape, double tolerance);

/// Writers compare p-curves with their edges in some points only; between them p-curves may swing
/// out, and the face with them. The edge's curve is what neighbours share: such p-curves become its
/// image on the surface, where it lies on the surface. Changes the shape in place.
/// @param tolerance  p-curves nearer than this, or than twice the edge's own tolerance, are left
///                   alone
/// @return number of p-curves replaced
int bring_pcurves_onto_edges(const TopoDS_Shape& shape, double tolerance);

}  // namespace patchwright::occ
