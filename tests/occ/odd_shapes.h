// Shapes that foot points find hard: degenerate sides, kinks, bends shorter than triangles.
#pragma once

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Wire.hxx>

#include <cmath>
#include <vector>

namespace patchwright::test {

inline TopoDS_Shape horn() {
    // A B-spline patch that is pointed at both ends of v, one of them a proper cusp-like tip.
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int i = 1; i <= 4; ++i) {
        for (int j = 1; j <= 4; ++j) {
            const double angle = M_PI * (i - 1) / 3, width = j == 1 || j == 4 ? 0.0 : 4.0 + j;
            poles(i, j) = gp_Pnt(width * std::cos(angle), width * std::sin(angle),
                                 10.0 * (j - 1) + 0.5 * width);
        }
    }
    TColStd_Array1OfReal knots(1, 2);
    knots(1) = 0;
    knots(2) = 1;
    TColStd_Array1OfInteger multiplicities(1, 2);
    multiplicities.Init(4);
    return BRepBuilderAPI_MakeFace(
               new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 3, 3),
               1e-7)
        .Face();
}

inline TopoDS_Shape kinked_strip() {
    // One face whose surface has a ridge: linear in u with an inner knot.
    TColgp_Array2OfPnt poles(1, 3, 1, 3);
    for (int j = 1; j <= 3; ++j) {
        for (int i = 1; i <= 3; ++i)
            poles.SetValue(i, j, gp_Pnt(10 * (i - 2), 20 * j, i == 2 ? 5 : 0));
    }
    TColStd_Array1OfReal knots(1, 3);
    for (int i = 1; i <= 3; ++i) knots(i) = i;
    TColStd_Array1OfInteger multiplicities(1, 3);
    multiplicities.Init(2);
    multiplicities(2) = 1;
    return BRepBuilderAPI_MakeFace(
               new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 1, 1),
               1e-7)
        .Face();
}

/// A strip that bends by `angle` within a knot span of 1/500 of its length and is plain elsewhere.
inline Handle(Geom_BSplineSurface) bent_strip(double angle) {
    const std::vector<double> along{-50, -34, -17, -0.1, 0.1, 17, 34, 50};
    TColgp_Array2OfPnt poles(1, 8, 1, 4);
    for (int i = 1; i <= 8; ++i) {
        const double s = along[std::size_t(i) - 1];
        for (int j = 1; j <= 4; ++j) {
            poles.SetValue(
                i, j, gp_Pnt(s * std::cos(angle / 2), 20.0 * j, std::abs(s) * std::sin(angle / 2)));
        }
    }
    TColStd_Array1OfReal u(1, 4), v(1, 2);
    u(1) = v(1) = 0;
    u(2) = 0.499;
    u(3) = 0.501;
    u(4) = v(2) = 1;
    TColStd_Array1OfInteger mu(1, 4), mv(1, 2);
    mu(1) = mu(4) = mv(1) = mv(2) = 4;
    mu(2) = mu(3) = 2;
    return new Geom_BSplineSurface(poles, u, v, mu, mv, 3, 3);
}

inline TopoDS_Shape wedge(double length, double half_thickness) {
    BRepBuilderAPI_MakePolygon triangle(gp_Pnt(0, -half_thickness, 0), gp_Pnt(0, half_thickness, 0),
                                        gp_Pnt(length, 0, 0), Standard_True);
    const TopoDS_Face face = BRepBuilderAPI_MakeFace(triangle.Wire());
    return BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, 50)).Shape();
}

}  // namespace patchwright::test
