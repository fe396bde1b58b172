#include "occ/turned.h"

#include "occ/shapes.h"

#include <BRepPrimAPI_MakeRevol.hxx>
#include <Geom_BezierCurve.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <gp.hxx>

namespace patchwright::test {

occ::CadModel turned(const std::vector<std::array<double, 2>>& profile) {
    TColgp_Array1OfPnt poles(1, int(profile.size()));
    for (int i = 1; i <= poles.Length(); ++i) {
        const auto& [radius, height] = profile[std::size_t(i) - 1];
        poles(i) = gp_Pnt(radius, 0.0, height);
    }
    const Handle(Geom_BezierCurve) curve = new Geom_BezierCurve(poles);
    const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(curve).Edge();
    return model_of(BRepPrimAPI_MakeRevol(edge, gp::OZ()).Shape());
}

}  // namespace patchwright::test
