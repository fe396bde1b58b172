#include "occ/foot/tight_bounds.h"

#include "occ/shapes.h"

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

namespace {

void check_box(const TopoDS_Shape& shape, const Vec3& low, const Vec3& high) {
    const geom::Box3 box = occ::tight_bounds(shape);
    const double tolerance = 1e-7 * (high - low).norm();
    CAPTURE(box.min.transpose(), box.max.transpose());
    CHECK((box.min - low).cwiseAbs().maxCoeff() < tolerance);
    CHECK((box.max - high).cwiseAbs().maxCoeff() < tolerance);
}

TopoDS_Shape turned(const TopoDS_Shape& shape) {
    gp_Trsf turn;
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), 0.7);
    return shape.Moved(TopLoc_Location(turn));
}

/// A bicubic bulge over [0, 3] x [0, 3] whose middle control points are at `height`.
Handle(Geom_BSplineSurface) bulge(double height) {
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int i = 1; i <= 4; ++i) {
        for (int j = 1; j <= 4; ++j) {
            const bool inner = (i == 2 || i == 3) && (j == 2 || j == 3);
            poles(i, j) = gp_Pnt(i - 1, j - 1, inner ? height : 0.0);
        }
    }
    TColStd_Array1OfReal knots(1, 2);
    TColStd_Array1OfInteger multiplicities(1, 2);
    knots(1) = 0.0;
    knots(2) = 1.0;
    multiplicities.Init(4);
    return new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 3, 3);
}

}  // namespace

TEST_CASE("bounds of analytic solids are exact in any position", "[occ][oracle]") {
    check_box(turned(BRepPrimAPI_MakeSphere(3.0).Shape()), Vec3::Constant(-3), Vec3::Constant(3));
    check_box(BRepPrimAPI_MakeTorus(5.0, 1.0).Shape(), Vec3(-6, -6, -1), Vec3(6, 6, 1));
    // A torus reaches sqrt(1 - n^2) R + r along an axis that makes cos n with its own.
    gp_Trsf turn;
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), 0.7);
    const gp_Dir axis = gp_Dir(0, 0, 1).Transformed(turn);
    Vec3 reach;
    for (int k = 0; k < 3; ++k)
        reach[k] = 5.0 * std::sqrt(1 - std::pow(axis.XYZ().Coord(k + 1), 2)) + 1.0;
    check_box(turned(BRepPrimAPI_MakeTorus(5.0, 1.0).Shape()), -reach, reach);
    check_box(BRepPrimAPI_MakeBox(gp_Pnt(1, 2, 3), 2.0, 3.0, 4.0).Shape(), Vec3(1, 2, 3),
              Vec3(3, 5, 7));
}

TEST_CASE("bounds are those of the surface, not of its control points", "[occ][oracle]") {
    const TopoDS_Face face = BRepBuilderAPI_MakeFace(bulge(1.0), 1e-7);
    // (B1 + B2)^2 at the middle: 0.75^2.
    check_box(face, Vec3(0, 0, 0), Vec3(3, 3, 0.5625));
}

TEST_CASE("what is trimmed away does not count", "[occ][oracle]") {
    // The strip u <= 1/4: its height is largest on its edge, (B1 + B2)(1/4) * 3/4.
    const TopoDS_Face face = BRepBuilderAPI_MakeFace(bulge(1.0), 0.0, 0.25, 0.0, 1.0, 1e-7);
    check_box(face, Vec3(0, 0, 0), Vec3(0.75, 3, (1 - 0.421875 - 0.015625) * 0.75));
}

TEST_CASE("nothing has no bounds", "[occ]") {
    CHECK(occ::tight_bounds(TopoDS_Compound()).empty());
    CHECK(occ::tight_bounds(TopoDS_Shape()).empty());
}
