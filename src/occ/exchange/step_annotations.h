// What a STEP file says of a model beside its shape.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <STEPControl_Writer.hxx>

namespace patchwright::occ {

/// Area, and for solids volume and centroid, as geometric validation properties (ISO 10303-242;
/// recommended practices of the CAx-IF).
void add_validation_properties(STEPControl_Writer& writer, const CadModel& model);

}  // namespace patchwright::occ
