// A part of what check_footpoint does, short enough for every day.
#include "occ/foot_point_oracle.h"

#include "support/skip.h"

#include <patchwright/occ/inspect.h>

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepLib.hxx>
#include <GCE2d_MakeSegment.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <catch2/catch.hpp>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <vector>

using namespace patchwright;

namespace {

void check_file(const std::filesystem::path& file) {
    CAPTURE(file.string());
    const occ::CadModel model = occ::read_cad(file).model;
    const occ::CadReference reference(model);
    const double size = reference.bounds().diagonal();
    const double tolerance = 1e-7 * size + occ::inspect(model).max_tolerance_mm;
    const test::OracleResult found = test::compare_with_kernel(
        reference, test::faces_only(model.impl().shape), 240, 2, tolerance);
    CAPTURE(found.worst.kind, found.worst.point.transpose());
    CHECK(found.points > 200);
    CHECK(found.kinds.size() == 6);
    CHECK(found.farther <= tolerance);
}

/// Bicubic faces that bend sharply one above the other, each trimmed by a polygon in (u, v) amid
/// what its surface goes on to be: feet beyond the trim are nearer than what is on the model.
TopoDS_Compound trimmed_waves(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<> height(-25.0, 25.0), corner(0.15, 0.45);
    TopoDS_Compound faces;
    const BRep_Builder builder;
    builder.MakeCompound(faces);
    for (int layer = 0; layer < 4; ++layer) {
        TColgp_Array2OfPnt poles(1, 4, 1, 4);
        for (int i = 1; i <= 4; ++i)
            for (int j = 1; j <= 4; ++j)
                poles(i, j) = gp_Pnt(33.0 * i, 33.0 * j, 15.0 * layer + height(random));
        const Handle(Geom_Surface) surface = new Geom_BezierSurface(poles);
        const std::array<gp_Pnt2d, 4> corners{gp_Pnt2d(corner(random), corner(random)),
                                              gp_Pnt2d(1.0 - corner(random), corner(random)),
                                              gp_Pnt2d(1.0 - corner(random), 1.0 - corner(random)),
                                              gp_Pnt2d(corner(random), 1.0 - corner(random))};
        BRepBuilderAPI_MakeWire wire;
        for (std::size_t k = 0; k < 4; ++k)
            wire.Add(BRepBuilderAPI_MakeEdge(
                GCE2d_MakeSegment(corners[k], corners[(k + 1) % 4]).Value(), surface));
        const TopoDS_Face face = BRepBuilderAPI_MakeFace(surface, wire.Wire()).Face();
        BRepLib::BuildCurves3d(face);
        builder.Add(faces, face);
    }
    return faces;
}

}  // namespace

TEST_CASE("foot points of the sample wing are no farther than the kernel's", "[occ][oracle]") {
    check_file(std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / "wing" / "wing.igs");
}

TEST_CASE("foot points of files are no farther than the kernel's", "[occ][legacy][oracle]") {
    const std::filesystem::path folder = PATCHWRIGHT_LEGACY_CAD_DIR;
    const auto names = {"tigl_d150_wing.igs",   "nosecone_sw.step",  "naca_wing_dealii.iges",
                        "seat_cpacs.stp",       "dtmb5415_bow.iges", "c172_wing_pyspline.igs",
                        "endplate_wing_vsp.stp"};
    if (!test::all_there(folder, names)) return;
    for (const char* name : names) check_file(folder / name);
}

TEST_CASE("foot points between many small faces are no farther than the kernel's",
          "[occ][oracle]") {
    // Edges are left out of a search where the foot is alone; here they are as near as the faces.
    for (const int side : {3, 7, 20}) {
        CAPTURE(side);
        const occ::CadModel model = test::wavy_sheet(side);
        const occ::CadReference reference(model);
        const double tolerance = 1e-9 * reference.bounds().diagonal();
        const test::OracleResult found = test::compare_with_kernel(
            reference, test::faces_only(model.impl().shape), 600, 5, tolerance);
        CAPTURE(found.worst.kind, found.worst.point.transpose());
        CHECK(found.points > 500);
        CHECK(found.farther <= tolerance);
    }
}

TEST_CASE("foot points where surfaces go on beyond the trim are no farther than the kernel's",
          "[occ][oracle]") {
    // Of seeds up to 300 only 75 shows that faces are searched too little: when to 0.3 of the
    // nearest edge's distance.
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 75U}) {
        CAPTURE(seed);
        const TopoDS_Compound faces = trimmed_waves(seed);
        const occ::CadReference reference(test::model_of(faces));
        // Edges' curves are fitted to their lines in (u, v).
        const double tolerance = 1e-6 * reference.bounds().diagonal();
        const test::OracleResult found =
            test::compare_with_kernel(reference, faces, 400, seed, tolerance);
        CAPTURE(found.worst.kind, found.worst.point.transpose());
        CHECK(found.points > 300);
        CHECK(found.farther <= tolerance);
    }
}

TEST_CASE("an edge is found though a face behind it has a foot of its own", "[occ]") {
    // A triangle over a large plate: off its long side its own foot is trimmed away.
    const auto face = [](const std::vector<gp_Pnt>& corners) {
        BRepBuilderAPI_MakePolygon polygon;
        for (const gp_Pnt& p : corners) polygon.Add(p);
        polygon.Close();
        return BRepBuilderAPI_MakeFace(polygon.Wire()).Face();
    };
    TopoDS_Compound both;
    const BRep_Builder builder;
    builder.MakeCompound(both);
    builder.Add(both, face({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}));
    builder.Add(both, face({{-50, -50, -3}, {50, -50, -3}, {50, 50, -3}, {-50, 50, -3}}));
    const occ::CadReference reference(test::model_of(both));
    for (const double x : {5.1, 6.0, 7.0, 8.0}) {
        for (const double off : {-2.0, 0.1, 2.0}) {
            const geom::Vec3 query(x + off, x - off, 0.0);
            CAPTURE(query.transpose());
            const double to_side = (2.0 * x - 10.0) / std::sqrt(2.0);
            CHECK(reference.foot_point(query).distance ==
                  Approx(std::min(to_side, 3.0)).epsilon(1e-12));
        }
    }
}

TEST_CASE("a round edge a little nearer than the face behind it is found", "[occ][oracle]") {
    // Off a disc in its plane the nearest point is on the circle; a plate below is farther by less
    // than the triangulation's chords are off the circle, so that it has the nearest foot on a
    // face, in the middle of large triangles. Only that the disc's triangles are as near, though
    // no foot is on them, says that edges must be looked at.
    const double radius = 10.0, height = 3.0;
    const gp_Circ circle(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), radius);
    BRepBuilderAPI_MakePolygon around(gp_Pnt(-50, -50, -height), gp_Pnt(50, -50, -height),
                                      gp_Pnt(50, 50, -height), gp_Pnt(-50, 50, -height), true);
    TopoDS_Compound both;
    const BRep_Builder builder;
    builder.MakeCompound(both);
    builder.Add(both, BRepBuilderAPI_MakeFace(
                          BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle)).Wire())
                          .Face());
    builder.Add(both, BRepBuilderAPI_MakeFace(around.Wire()).Face());
    const occ::CadReference reference(test::model_of(both));
    for (const double farther : {1e-5, 1e-4, 1e-3, 5e-3}) {
        const double distance = height - farther;
        for (int i = 0; i < 100; ++i) {
            const double angle = 0.01 + 2.0 * std::numbers::pi * i / 100;
            const geom::Vec3 outward(std::cos(angle), std::sin(angle), 0.0);
            const auto foot = reference.foot_point((radius + distance) * outward);
            CAPTURE(farther, angle);
            CHECK(foot.distance == Approx(distance).epsilon(1e-12));
            // The answer is a point to 1e-12 of the model's size of 142.
            CHECK((foot.point - radius * outward).norm() < 1e-9);
        }
    }
}

TEST_CASE("edges of high degree with knots inside are found as the kernel finds them",
          "[occ][oracle]") {
    // Five times continuous where its polynomials meet: the kernel's adaptor calls it one piece.
    constexpr int degree = 6, count = 10;
    TColgp_Array1OfPnt poles(1, count);
    for (int i = 0; i < count; ++i)
        poles(i + 1) = gp_Pnt(100.0 * i / (count - 1), i % 2 == 0 ? 0.0 : 60.0, 0.0);
    poles(count) = gp_Pnt(100.0, 0.0, 0.0);
    TColStd_Array1OfReal knots(1, 5);
    TColStd_Array1OfInteger multiplicities(1, 5);
    const std::array<double, 5> at{0.0, 0.2, 0.5, 0.9, 1.0};
    for (int i = 0; i < 5; ++i) {
        knots(i + 1) = at[std::size_t(i)];
        multiplicities(i + 1) = i == 0 || i == 4 ? degree + 1 : 1;
    }
    const Handle(Geom_BSplineCurve) curve =
        new Geom_BSplineCurve(poles, knots, multiplicities, degree);
    BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(curve).Edge());
    wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(100, 0, 0), gp_Pnt(100, -50, 0)).Edge());
    wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(100, -50, 0), gp_Pnt(0, -50, 0)).Edge());
    wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(0, -50, 0), gp_Pnt(0, 0, 0)).Edge());
    const occ::CadModel model = test::model_of(
        BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), wire.Wire()).Face());
    const occ::CadReference reference(model);
    const test::OracleResult found =
        test::compare_with_kernel(reference, test::faces_only(model.impl().shape), 600, 3, 1e-6);
    CAPTURE(found.worst.kind, found.worst.point.transpose());
    CHECK(found.points > 500);
    // The edge's own tolerance.
    CHECK(found.farther <= 1e-7);
}
