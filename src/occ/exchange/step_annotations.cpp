#include "occ/exchange/step_annotations.h"

#include "occ/exchange/cad_model_impl.h"

#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <STEPConstruct_ValidationProps.hxx>
#include <TopExp_Explorer.hxx>
#include <XSControl_WorkSession.hxx>

namespace patchwright::occ {

void add_validation_properties(STEPControl_Writer& writer, const CadModel& model) {
    const TopoDS_Shape& shape = model.impl().shape;
    STEPConstruct_ValidationProps properties(writer.WS());
    GProp_GProps area;
    BRepGProp::SurfaceProperties(shape, area);
    properties.AddArea(shape, area.Mass());
    GProp_GProps volume;
    for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next()) {
        GProp_GProps of_solid;
        BRepGProp::VolumeProperties(it.Current(), of_solid);
        volume.Add(of_solid);
    }
    const bool solid = volume.Mass() > 0.0;
    if (solid) properties.AddVolume(shape, volume.Mass());
    properties.AddCentroid(shape, solid ? volume.CentreOfMass() : area.CentreOfMass());
}

}  // namespace patchwright::occ
