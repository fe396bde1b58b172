// Shapes and kernel oracles shared by the tests of references and deviations.
#pragma once

#include "occ/exchange/cad_model_impl.h"

#include <patchwright/occ/cad_reference.h>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRep_Builder.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <Geom_BSplineCurve.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Ax2.hxx>
#include <gp_Trsf.hxx>

#include <cmath>
#include <memory>

namespace patchwright::test {

inline occ::CadModel model_of(const TopoDS_Shape& shape) {
    auto impl = std::make_shared<occ::CadModel::Impl>();
    impl->shape = shape;
    return occ::CadModel(impl);
}

/// The faces alone: against a solid the kernel answers 0 inside.
inline TopoDS_Compound faces_only(const TopoDS_Shape& shape) {
    TopoDS_Compound result;
    const BRep_Builder builder;
    builder.MakeCompound(result);
    for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
        builder.Add(result, it.Current());
    return result;
}

inline double kernel_distance(const TopoDS_Shape& faces, const geom::Vec3& p) {
    const TopoDS_Vertex vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(p.x(), p.y(), p.z()));
    BRepExtrema_DistShapeShape search(vertex, faces, Extrema_ExtFlag_MIN);
    return search.IsDone() ? search.Value() : -1.0;
}

inline TopoDS_Wire section_wire(double span, double chord, double thickness, double offset) {
    // A closed symmetric section with a blunt trailing edge: one curve and one line.
    constexpr int points = 25;
    Handle(TColgp_HArray1OfPnt) p = new TColgp_HArray1OfPnt(1, points);
    for (int i = 1; i <= points; ++i) {
        const double angle = 2 * M_PI * (i - 1) / (points - 1);
        const double x = 0.5 * (1 + std::cos(angle)), root = std::sqrt(x);
        const double half = 5 * (0.2969 * root - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x -
                                 0.0915 * x * x * x * x);
        const double y = i == 13 ? 0.0 : (angle < M_PI ? half : -half);
        p->SetValue(i, gp_Pnt(offset + chord * x, chord * thickness * y, span));
    }
    GeomAPI_Interpolate fit(p, Standard_False, 1e-9);
    fit.Perform();
    const TopoDS_Edge around = BRepBuilderAPI_MakeEdge(fit.Curve());
    const TopoDS_Edge base = BRepBuilderAPI_MakeEdge(p->Value(points), p->Value(1));
    return BRepBuilderAPI_MakeWire(around, base).Wire();
}

/// A swept, tapered wing through sections: B-spline skin, blunt trailing edge, plane ends.
inline TopoDS_Shape wing() {
    BRepOffsetAPI_ThruSections loft(Standard_True, Standard_False);
    loft.AddWire(section_wire(0.0, 100.0, 0.12, 0.0));
    loft.AddWire(section_wire(150.0, 80.0, 0.11, 20.0));
    loft.AddWire(section_wire(300.0, 45.0, 0.09, 60.0));
    loft.Build();
    return loft.Shape();
}

inline TopoDS_Shape rotated_box(double dx, double dy, double dz, const gp_Pnt& at, double angle) {
    gp_Trsf turn, move;
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), angle);
    move.SetTranslation(gp_Vec(gp_Pnt(0, 0, 0), at));
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(dx, dy, dz).Shape();
    return box.Moved(TopLoc_Location(move) * TopLoc_Location(turn));
}

inline TopoDS_Shape cut_cylinder() {
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(10.0, 40.0).Shape(),
                           rotated_box(30, 30, 30, gp_Pnt(2, -3, 22), 0.6))
        .Shape();
}

inline TopoDS_Shape plate_with_hole() {
    return BRepAlgoAPI_Cut(
               BRepPrimAPI_MakeBox(40.0, 30.0, 4.0).Shape(),
               BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(18, 14, -1), gp_Dir(0, 0, 1)), 7.0, 10.0)
                   .Shape())
        .Shape();
}

}  // namespace patchwright::test
