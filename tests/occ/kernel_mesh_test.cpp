// Where the kernel's refinement of triangles is ended, and what foot points make of the rest.
#include "occ/kernel_mesh.h"

#include "occ/shapes.h"

#include <patchwright/occ/cad_reference.h>

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Line.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Plane.hxx>
#include <Poly_Triangulation.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <catch2/catch.hpp>
#include <gp.hxx>
#include <gp_Pln.hxx>

#include <array>
#include <cmath>

using namespace patchwright;

namespace {

/// A quarter of a ring of paper: the section goes in from radius 70, turns, and comes out again.
TopoDS_Face film(double thickness) {
    const double half = 0.5 * thickness, c = 4.0 / 3.0 * (std::sqrt(2.0) - 1.0);
    const std::array<double, 4> radius{70, 40, 40, 70}, z{half, half, -half, -half};
    const std::array<double, 4> x{1, 1, c, 0}, y{0, c, 1, 1};
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            poles.SetValue(int(i) + 1, int(j) + 1,
                           gp_Pnt(radius[i] * x[j], radius[i] * y[j], z[i]));
    return BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-7).Face();
}

/// z = 180 u (1 - u) v (1 - v) mm over 30 mm squared.
Handle(Geom_Surface) hill() {
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            poles.SetValue(i + 1, j + 1,
                           gp_Pnt(10 * i, 10 * j, i % 3 != 0 && j % 3 != 0 ? 20.0 : 0.0));
    return new Geom_BezierSurface(poles);
}

/// A part of the hill whose border runs along u = 1 to and fro and beyond its end.
TopoDS_Face hill_with_crossed_border() {
    const Handle(Geom_Surface) surface = hill();
    const std::array<gp_Pnt2d, 9> border{gp_Pnt2d(0, 0),    gp_Pnt2d(1, 0),      gp_Pnt2d(1, .133),
                                         gp_Pnt2d(1, .069), gp_Pnt2d(1, 1.02),   gp_Pnt2d(1, .96),
                                         gp_Pnt2d(1, .97),  gp_Pnt2d(.36, .475), gp_Pnt2d(0, .287)};
    BRepBuilderAPI_MakeWire wire;
    for (std::size_t i = 0; i < border.size(); ++i) {
        const gp_Vec2d along(border[i], border[(i + 1) % border.size()]);
        wire.Add(BRepBuilderAPI_MakeEdge(new Geom2d_Line(border[i], gp_Dir2d(along)), surface, 0,
                                         along.Magnitude())
                     .Edge());
    }
    TopoDS_Face face = BRepBuilderAPI_MakeFace(surface, wire.Wire()).Face();
    BRepLib::BuildCurves3d(face);
    return face;
}

/// A flat square of 30 mm, one of whose control points inside is 1e17 mm out of place.
TopoDS_Face spike() {
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            poles.SetValue(i + 1, j + 1, gp_Pnt(10 * i, 10 * j, i == 1 && j == 1 ? 1e17 : 0.0));
    return BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-7).Face();
}

/// A square of 100 mm; one side is a saw of half as many teeth as an edge may have nodes.
TopoDS_Face sawn_square() {
    const int corners = occ::most_edge_nodes + 2;
    TColgp_Array1OfPnt poles(1, corners);
    TColStd_Array1OfReal knots(1, corners);
    TColStd_Array1OfInteger multiplicities(1, corners);
    for (int i = 1; i <= corners; ++i) {
        const double at = double(i - 1) / (corners - 1);
        poles.SetValue(i, gp_Pnt(100 * at, i % 2 == 0 ? -1.0 : 0.0, 0));
        knots.SetValue(i, at);
        multiplicities.SetValue(i, i == 1 || i == corners ? 2 : 1);
    }
    const gp_Pnt end = poles.Last(), above(100, 100, 0), left(0, 100, 0);
    BRepBuilderAPI_MakeWire wire(
        BRepBuilderAPI_MakeEdge(new Geom_BSplineCurve(poles, knots, multiplicities, 1)).Edge(),
        BRepBuilderAPI_MakeEdge(end, above).Edge(), BRepBuilderAPI_MakeEdge(above, left).Edge(),
        BRepBuilderAPI_MakeEdge(left, poles.First()).Edge());
    return BRepBuilderAPI_MakeFace(new Geom_Plane(gp_Pln(gp::XOY())), wire.Wire()).Face();
}

int count_nodes(const TopoDS_Face& face) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
    return mesh.IsNull() ? 0 : mesh->NbNodes();
}

IMeshTools_Parameters parameters_of(double deflection_mm) {
    IMeshTools_Parameters parameters;
    parameters.Deflection = deflection_mm;
    parameters.Angle = 0.3;
    return parameters;
}

int limited_nodes_of(const TopoDS_Face& face, double deflection_mm) {
    occ::mesh_faces(face, parameters_of(deflection_mm));
    const int nodes = count_nodes(face);
    BRepTools::Clean(face);
    return nodes;
}

struct Nodes {
    int limited, kernel;
};

Nodes nodes_of(const TopoDS_Face& face, double deflection_mm) {
    Nodes result{};
    result.limited = limited_nodes_of(face, deflection_mm);
    const BRepMesh_IncrementalMesh mesher(face, parameters_of(deflection_mm));
    result.kernel = count_nodes(face);
    BRepTools::Clean(face);
    return result;
}

}  // namespace

TEST_CASE("triangles are the kernel's where its refinement ends by itself", "[occ][mesh][oracle]") {
    const Nodes nodes =
        nodes_of(BRepBuilderAPI_MakeFace(hill(), Precision::Confusion()).Face(), 0.01);
    CHECK(nodes.kernel > 1000);
    CHECK(nodes.limited == nodes.kernel);
}

TEST_CASE("the fold of a film is refined up to a number of nodes", "[occ][mesh]") {
    // Without the limit the number grows by half each pass; 68,000 where a fuzzer's film took 15 s.
    const TopoDS_Face face = film(2e-4);
    const Nodes nodes = nodes_of(face, 0.003);
    CHECK(nodes.kernel > occ::most_face_nodes);
    CHECK(nodes.limited <= occ::most_face_nodes);
    CHECK(nodes.limited > occ::most_face_nodes / 4);

    const occ::CadReference reference(test::model_of(face), {.deflection_rel = 3e-5});
    for (const double angle : {0.1, 0.7, 1.4}) {
        const geom::Vec3 p(60 * std::cos(angle), 60 * std::sin(angle), 5.0);
        const geom::FootPoint foot = reference.foot_point(p);
        CHECK(std::abs(foot.distance - 5.0) <= 2e-4);
    }
}

TEST_CASE("a face whose border crosses itself is not refined pass by pass", "[occ][mesh]") {
    // Each pass of the kernel walks through all triangles for a polygon that is not there: 35 s for
    // 7,000 nodes of a file with one wrong number.
    const TopoDS_Face face = hill_with_crossed_border();
    const Nodes nodes = nodes_of(face, 0.003);
    CHECK(nodes.limited > 0);
    CHECK(nodes.limited * 4 < nodes.kernel);

    // What the kernel left coarse is divided: feet are on the hill.
    const occ::CadReference reference(test::model_of(face), {.deflection_rel = 1e-4});
    for (const double x : {8.0, 15.0, 22.0}) {
        const double u = x / 30.0, v = 0.2;
        const geom::Vec3 on_hill(x, 30 * v, 180 * u * (1 - u) * v * (1 - v));
        CHECK(reference.foot_point(on_hill).distance < 1e-9);
    }
}

TEST_CASE("a spike is triangulated in bounded work", "[occ][mesh]") {
    // The kernel asks for 188,223 by 188,223 cells, into each of which it puts a large circle.
    CHECK(limited_nodes_of(spike(), 0.01) > 50);
}

TEST_CASE("a face with an edge that winds too often is left to its surface", "[occ][mesh]") {
    // The kernel compares each node with those near it: two minutes for a file whose trimming curve
    // has one wrong number and 20,000 nodes.
    const TopoDS_Face face = sawn_square();
    CHECK(limited_nodes_of(face, 0.01) == 0);

    const occ::CadReference reference(test::model_of(face), {.deflection_rel = 1e-4});
    for (const double x : {8.0, 50.0, 92.0})
        CHECK(std::abs(reference.foot_point({x, 40, 5}).distance - 5.0) < 1e-9);
}
