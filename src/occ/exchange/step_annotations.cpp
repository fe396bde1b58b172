#include "occ/exchange/step_annotations.h"

#include "occ/brep/mass.h"
#include "occ/exchange/cad_model_impl.h"

#include <STEPConstruct_ValidationProps.hxx>
#include <XSControl_WorkSession.hxx>

namespace patchwright::occ {

void add_validation_properties(STEPControl_Writer& writer, const CadModel& model) {
    const TopoDS_Shape& shape = model.impl().shape;
    STEPConstruct_ValidationProps properties(writer.WS());
    const Mass mass = measure_mass(shape);
    properties.AddArea(shape, mass.area_mm2);
    if (mass.volume_mm3 > 0.0) properties.AddVolume(shape, mass.volume_mm3);
    properties.AddCentroid(shape, gp_Pnt(mass.centroid.x(), mass.centroid.y(), mass.centroid.z()));
}

}  // namespace patchwright::occ
