// Bezier and B-spline surfaces as polynomials, one a span.
#pragma once

#include "occ/foot/surface_evaluator.h"

namespace patchwright::occ {

/// Null when the surface is neither a Bezier nor a B-spline surface, or of so high a degree that
/// powers lose digits (above 15).
/// @param memory  as of make_evaluator
std::shared_ptr<const SurfaceEvaluator> make_spline_spans(const Handle(Geom_Surface) & surface,
                                                          std::pmr::memory_resource* memory);

}  // namespace patchwright::occ
