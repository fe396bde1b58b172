#include "make_lofts.h"

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <BRep_Tool.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomFill.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopoDS.hxx>

#include <array>
#include <cmath>
#include <stdexcept>

namespace lofts {

namespace {

Curve interpolate(const std::vector<gp_Pnt>& points, const std::vector<double>& parameters) {
    const int n = static_cast<int>(points.size());
    Handle(TColgp_HArray1OfPnt) p = new TColgp_HArray1OfPnt(1, n);
    Handle(TColStd_HArray1OfReal) t = new TColStd_HArray1OfReal(1, n);
    for (int i = 0; i < n; ++i) {
        p->SetValue(i + 1, points[i]);
        t->SetValue(i + 1, parameters[i]);
    }
    // No tolerance: points of a nose coincide.
    GeomAPI_Interpolate interpolation(p, t, false, 0.0);
    interpolation.Perform();
    if (!interpolation.IsDone()) throw std::runtime_error("interpolation failed");
    return interpolation.Curve();
}

}  // namespace

/// Along every section first, then every column of poles.
Surface loft(const std::vector<std::vector<gp_Pnt>>& sections, const std::vector<double>& u,
             const std::vector<double>& v) {
    std::vector<Curve> along;
    for (const auto& points : sections) along.push_back(interpolate(points, u));
    std::vector<Curve> across;
    for (int i = 1; i <= along.front()->NbPoles(); ++i) {
        std::vector<gp_Pnt> column;
        for (const Curve& section : along) column.push_back(section->Pole(i));
        across.push_back(interpolate(column, v));
    }
    const Curve &first = along.front(), &side = across.front();
    TColgp_Array2OfPnt poles(1, first->NbPoles(), 1, side->NbPoles());
    for (int i = 1; i <= poles.ColLength(); ++i) {
        for (int j = 1; j <= poles.RowLength(); ++j)
            poles.SetValue(i, j, across[std::size_t(i - 1)]->Pole(j));
    }
    return new Geom_BSplineSurface(poles, first->Knots(), side->Knots(), first->Multiplicities(),
                                   side->Multiplicities(), first->Degree(), side->Degree());
}

Surface part(const Surface& surface, double u0, double u1, double v0, double v1) {
    Surface copy = Surface::DownCast(surface->Copy());
    copy->Segment(u0, u1, v0, v1);
    return copy;
}

Curve as_spline(const Handle(Geom_Curve) & curve) { return Curve::DownCast(curve); }

Curve line(const gp_Pnt& a, const gp_Pnt& b) {
    TColgp_Array1OfPnt poles(1, 2);
    poles.SetValue(1, a);
    poles.SetValue(2, b);
    TColStd_Array1OfReal knots(1, 2);
    knots.SetValue(1, 0);
    knots.SetValue(2, 1);
    TColStd_Array1OfInteger multiplicities(1, 2);
    multiplicities.Init(2);
    return new Geom_BSplineCurve(poles, knots, multiplicities, 1);
}

Surface ruled(const Curve& first, const Curve& second) {
    return Surface::DownCast(GeomFill::Surface(first, second));
}

Surface rounded_cap(
    const Curve& upper, const Curve& lower,
    const std::function<gp_XYZ(const gp_XYZ& centre, const gp_XYZ& half)>& outward) {
    // A unit half circle as two cubic Bezier arcs that meet C1: cosine and sine of the poles.
    const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
    const std::array<double, 6> cosine{1, 1, k, -k, -1, -1};
    const std::array<double, 6> sine{0, k, 1, 1, k, 0};
    TColgp_Array2OfPnt poles(1, upper->NbPoles(), 1, 6);
    for (int i = 1; i <= upper->NbPoles(); ++i) {
        const gp_XYZ a = upper->Pole(i).XYZ();
        const gp_XYZ b = lower->Pole(i).XYZ();
        const gp_XYZ centre = (a + b) / 2;
        const gp_XYZ half = (a - b) / 2;
        const gp_XYZ out = outward(centre, half);
        for (int j = 1; j <= 6; ++j) {
            const gp_XYZ p = centre + half * cosine[j - 1] + out * sine[j - 1];
            poles.SetValue(i, j, j == 1 ? upper->Pole(i) : j == 6 ? lower->Pole(i) : gp_Pnt(p));
        }
    }
    TColStd_Array1OfReal knots(1, 3);
    TColStd_Array1OfInteger multiplicities(1, 3);
    for (int i = 1; i <= 3; ++i) {
        knots.SetValue(i, i - 1);
        multiplicities.SetValue(i, i == 2 ? 2 : 4);
    }
    return new Geom_BSplineSurface(poles, upper->Knots(), knots, upper->Multiplicities(),
                                   multiplicities, 3, 3);
}

TopoDS_Face face_of(const Surface& surface) {
    constexpr double degenerate_mm = 1e-7;
    return BRepBuilderAPI_MakeFace(surface, degenerate_mm).Face();
}

TopoDS_Shell sewn(const std::vector<TopoDS_Face>& faces) {
    constexpr double gap_mm = 1e-5;  // common borders differ by rounding only
    BRepBuilderAPI_Sewing sewing(gap_mm);
    for (const TopoDS_Face& face : faces) sewing.Add(face);
    sewing.Perform();
    if (sewing.SewedShape().ShapeType() != TopAbs_SHELL)
        throw std::runtime_error("the faces are not connected");
    return TopoDS::Shell(sewing.SewedShape());
}

TopoDS_Solid sewn_solid(const std::vector<TopoDS_Face>& faces) {
    const TopoDS_Shell shell = sewn(faces);
    if (!BRep_Tool::IsClosed(shell)) throw std::runtime_error("the faces do not close");
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(shell).Solid();
    BRepLib::OrientClosedSolid(solid);
    if (!BRepCheck_Analyzer(solid).IsValid()) throw std::runtime_error("the solid is not valid");
    return solid;
}

}  // namespace lofts
