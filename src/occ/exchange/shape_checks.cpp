#include "occ/exchange/shape_checks.h"

#include <BRep_Tool.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <fmt/format.h>

#include <cmath>

namespace patchwright::occ {

namespace {

bool is_finite(const gp_Pnt& p) {
    return std::isfinite(p.X()) && std::isfinite(p.Y()) && std::isfinite(p.Z());
}

bool has_finite_poles(const Handle(Geom_Surface) & surface) {
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(surface);
    if (spline.IsNull()) return true;
    for (int u = 1; u <= spline->NbUPoles(); ++u)
        for (int v = 1; v <= spline->NbVPoles(); ++v)
            if (!is_finite(spline->Pole(u, v))) return false;
    return true;
}

bool has_finite_poles(const Handle(Geom_Curve) & curve) {
    const auto spline = Handle(Geom_BSplineCurve)::DownCast(curve);
    if (spline.IsNull()) return true;
    for (int i = 1; i <= spline->NbPoles(); ++i)
        if (!is_finite(spline->Pole(i))) return false;
    return true;
}

const char* problem_of(const TopoDS_Face& face) {
    TopLoc_Location location;
    const Handle(Geom_Surface)& surface = BRep_Tool::Surface(face, location);
    if (surface.IsNull()) return "has no surface";
    return has_finite_poles(surface) ? nullptr : "has a surface that is not finite";
}

const char* problem_of(const TopoDS_Edge& edge) {
    TopLoc_Location location;
    double first = 0.0, last = 0.0;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, location, first, last);
    if (!curve.IsNull())
        return has_finite_poles(curve) && std::isfinite(first) && std::isfinite(last)
                   ? nullptr
                   : "has a curve that is not finite";
    Handle(Geom2d_Curve) on_surface;
    Handle(Geom_Surface) surface;
    BRep_Tool::CurveOnSurface(edge, on_surface, surface, location, first, last);
    return on_surface.IsNull() ? "has no curve" : nullptr;
}

const char* problem_of(const TopoDS_Vertex& vertex) {
    return is_finite(BRep_Tool::Pnt(vertex)) && std::isfinite(BRep_Tool::Tolerance(vertex))
               ? nullptr
               : "is not finite";
}

template <class Shape>
std::optional<std::string> first_problem(const TopoDS_Shape& shape, TopAbs_ShapeEnum type,
                                         const char* name, Shape (*cast)(const TopoDS_Shape&)) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, type, map);
    for (int i = 1; i <= map.Extent(); ++i)
        if (const char* problem = problem_of(cast(map(i))))
            return fmt::format("{} {} {}", name, i, problem);
    return std::nullopt;
}

}  // namespace

std::optional<std::string> missing_geometry(const TopoDS_Shape& shape) {
    if (const auto found = first_problem<TopoDS_Face>(
            shape, TopAbs_FACE, "face", [](const TopoDS_Shape& s) { return TopoDS::Face(s); }))
        return found;
    if (const auto found = first_problem<TopoDS_Edge>(
            shape, TopAbs_EDGE, "edge", [](const TopoDS_Shape& s) { return TopoDS::Edge(s); }))
        return found;
    return first_problem<TopoDS_Vertex>(shape, TopAbs_VERTEX, "vertex",
                                        [](const TopoDS_Shape& s) { return TopoDS::Vertex(s); });
}

}  // namespace patchwright::occ
