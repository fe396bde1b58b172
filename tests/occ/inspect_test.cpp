#include "occ/brep/mass.h"
#include "occ/kernel_points.h"
#include "occ/shapes.h"
#include "support/cages.h"

#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/occ/inspect_closely.h>
#include <patchwright/patch/extract.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <GProp_GProps.hxx>
#include <catch2/catch.hpp>

using namespace patchwright;

TEST_CASE("solids are measured", "[occ][oracle]") {
    const occ::Inspection box =
        occ::inspect(test::model_of(BRepPrimAPI_MakeBox(gp_Pnt(1, 2, 3), 2.0, 3.0, 4.0).Shape()));
    CHECK(box.solids == 1);
    CHECK(box.faces_by_kind == std::map<std::string, int>{{"plane", 6}});
    CHECK(box.edges == 12);
    CHECK(box.vertices == 8);
    CHECK(box.volume_mm3 == Approx(24.0));
    CHECK(box.area_mm2 == Approx(52.0));
    CHECK((box.bounds.min - geom::Vec3(1, 2, 3)).norm() < 1e-9);
    CHECK(box.closed);
    CHECK(box.valid);
    CHECK_FALSE(box.all_bicubic);

    const occ::Inspection sphere =
        occ::inspect(test::model_of(BRepPrimAPI_MakeSphere(3.0).Shape()));
    CHECK(sphere.volume_mm3 == Approx(36.0 * M_PI));
    CHECK(sphere.closed);  // its seam is used twice by the one face
}

/// By the kernel's adaptive quadrature; its ordinary one is off by some 1e-6.
occ::Mass precise_mass(const TopoDS_Shape& shape) {
    constexpr double error_rel = 1e-9;
    GProp_GProps area, volume;
    BRepGProp::SurfaceProperties(shape, area, error_rel);
    if (TopExp_Explorer(shape, TopAbs_SOLID).More())
        BRepGProp::VolumeProperties(shape, volume, error_rel);
    return {area.Mass(), volume.Mass(),
            occ::vec((volume.Mass() > 0.0 ? volume : area).CentreOfMass())};
}

TEST_CASE("bicubic models have the area and volume that the kernel finds", "[occ][oracle]") {
    gp_Trsf moved;
    moved.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 0)), 0.7);
    const TopLoc_Location place(moved);
    std::vector<TopoDS_Shape> shapes;
    for (const mesh::Cage& cage : {test::cube(2.0), test::grid(3, 4)}) {
        const TopoDS_Shape shape = occ::assemble(patch::extract(cage).patches).impl().shape;
        shapes.insert(shapes.end(), {shape, shape.Moved(place), shape.Reversed()});
    }
    for (const TopoDS_Shape& shape : shapes) {
        const occ::Inspection bicubic = occ::inspect(test::model_of(shape));
        CHECK(bicubic.all_bicubic);
        const occ::Mass kernel = precise_mass(shape);
        CHECK(bicubic.area_mm2 == Approx(kernel.area_mm2).epsilon(1e-6));
        CHECK(bicubic.volume_mm3 == Approx(kernel.volume_mm3).epsilon(1e-9));
        CHECK((occ::measure_mass(shape).centroid - kernel.centroid).norm() < 1e-7);
    }
}

TEST_CASE("a periodic bicubic surface has the area that the kernel finds", "[occ][oracle]") {
    constexpr int around = 8;
    TColgp_Array2OfPnt poles(1, around, 1, 4);
    for (int i = 1; i <= around; ++i)
        for (int j = 1; j <= 4; ++j)
            poles(i, j) = gp_Pnt(std::cos(i * M_PI / 4), std::sin(i * M_PI / 4) * (1 + 0.1 * j), j);
    TColStd_Array1OfReal knots_u(1, around + 1), knots_v(1, 2);
    TColStd_Array1OfInteger once(1, around + 1), four_times(1, 2);
    for (int i = 1; i <= around + 1; ++i) knots_u(i) = i;
    knots_v(1) = 0;
    knots_v(2) = 1;
    once.Init(1);
    four_times.Init(4);
    const Handle(Geom_BSplineSurface) tube =
        new Geom_BSplineSurface(poles, knots_u, knots_v, once, four_times, 3, 3, true, false);
    const TopoDS_Face face = BRepBuilderAPI_MakeFace(tube, 1e-7).Face();
    REQUIRE_FALSE(occ::whole_bicubic(face).IsNull());
    CHECK(occ::measure_mass(face).area_mm2 == Approx(precise_mass(face).area_mm2).epsilon(1e-6));
}

TEST_CASE("free and non-manifold edges are counted", "[occ]") {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape();
    TopoDS_Compound faces;
    const BRep_Builder builder;
    builder.MakeCompound(faces);
    int n = 0;
    for (TopExp_Explorer it(box, TopAbs_FACE); it.More(); it.Next()) {
        if (n++ < 5) builder.Add(faces, it.Current());
    }
    const occ::Inspection open = occ::inspect(test::model_of(faces));
    CHECK(open.free_edges == 4);
    CHECK_FALSE(open.closed);
    CHECK(open.volume_mm3 == 0.0);
}

TEST_CASE("kinks and creases of known angle are told apart", "[occ][oracle]") {
    const occ::CadModel box = test::model_of(BRepPrimAPI_MakeBox(2.0, 2.0, 2.0).Shape());
    const patch::Continuity all = occ::measure_continuity(box, geom::Points(0, 3));
    CHECK(all.max_kink_rad == Approx(M_PI / 2));
    CHECK(all.smooth_edges == 12);
    CHECK(all.max_gap_mm < 1e-12);

    geom::Points creases(1, 3);
    creases << 1, 0, 0;  // the middle of one edge
    const patch::Continuity one = occ::measure_continuity(box, creases);
    CHECK(one.crease_edges == 1);
    CHECK(one.smooth_edges == 11);
    CHECK_THROWS(occ::measure_continuity(box, creases, {.samples_per_edge = 1}));
}

TEST_CASE("kinks beside given vertices are told from the others", "[occ][oracle]") {
    const occ::CadModel box = test::model_of(BRepPrimAPI_MakeBox(2.0, 2.0, 2.0).Shape());
    geom::Points corner(1, 3);
    corner << 2, 2, 2;
    const auto c = occ::measure_continuity(
        box, geom::Points(0, 3), {.singular_points = corner, .singular_distance_mm = 0.1});
    CHECK(c.near_singular_kink_rad == Approx(M_PI / 2));
    CHECK((c.near_singular_kink_at - geom::Vec3(2, 2, 2)).norm() <= 0.1);
    CHECK(c.max_kink_rad == Approx(M_PI / 2));  // at the other corners
    CHECK((c.kink_at - geom::Vec3(2, 2, 2)).norm() > 0.1);
}

TEST_CASE("a crease that ends has a kink only where it ends in a fold", "[occ][oracle]") {
    // A ridge of three control points from the boundary to the middle. Its end is smooth as a dart,
    // and has no tangent plane where it is tagged as a corner.
    const auto ridge = [](std::vector<mesh::VertexTagInput> corners) {
        constexpr double sharp = mesh::infinite_sharpness;
        mesh::Cage cage = test::grid(
            4, 4, {.creases = {{2, 7, sharp}, {7, 12, sharp}}, .corners = std::move(corners)});
        for (const int v : {2, 7, 12}) cage.points(v, 2) = 0.5;
        return patch::extract(cage);
    };
    const auto measure = [](const patch::Extraction& e, double distance) {
        return occ::measure_continuity(
            occ::assemble(e.patches), patch::crease_midpoints(e.patches),
            {.singular_points = patch::singular_points(e), .singular_distance_mm = distance});
    };
    const patch::Extraction dart = ridge({});
    CHECK(patch::singular_points(dart).rows() == 0);
    CHECK(measure(dart, 0.1).max_kink_rad < 1e-6);

    const patch::Extraction fold = ridge({{12, mesh::infinite_sharpness}});
    const geom::Vec3 end(2, 2, 0.5);
    REQUIRE(patch::singular_points(fold).rows() == 1);
    CHECK((patch::singular_points(fold).row(0).transpose() - end).norm() < 1e-12);
    const patch::Continuity all = measure(fold, 0.0);
    CHECK(all.max_kink_rad > 1.0);
    CHECK(all.near_singular_kink_rad == 0.0);
    const patch::Continuity beyond = measure(fold, 0.1);
    CHECK(beyond.max_kink_rad < 1e-6);
    CHECK(beyond.near_singular_kink_rad == all.max_kink_rad);
    CHECK(beyond.near_singular_kink_at == all.kink_at);
    // The edges' first regular samples are 0.1 away: the kink is found just beyond the distance.
    const patch::Continuity close = measure(fold, 1e-3);
    CHECK(close.max_kink_rad > 0.3);
    CHECK((close.kink_at - end).norm() > 1e-3);
    CHECK((close.kink_at - end).norm() < 5e-3);
}

TEST_CASE("a cylinder meets its own seam without a kink", "[occ][oracle]") {
    const occ::CadModel cylinder = test::model_of(BRepPrimAPI_MakeCylinder(1.0, 3.0).Shape());
    const patch::Continuity c = occ::measure_continuity(cylinder, geom::Points(0, 3));
    CHECK(c.max_kink_rad == Approx(M_PI / 2));  // at the ends
    CHECK(c.smooth_edges == 3);
}

TEST_CASE("a closer look finds small parts, features and mass", "[occ][oracle]") {
    const occ::CloseInspection box = occ::inspect_closely(
        test::model_of(BRepPrimAPI_MakeBox(gp_Pnt(1, 2, 3), 2.0, 3.0, 4.0).Shape()));
    CHECK(box.smallest_area_mm2 == Approx(6.0));
    REQUIRE(box.narrowest);
    CHECK(box.narrowest->width_mm == Approx(2 * 6.0 / 10.0));
    REQUIRE(box.shortest_edge);
    CHECK(box.shortest_edge->length_mm == Approx(2.0));
    CHECK(box.sharp_edges == 12);
    CHECK(box.sharp_curves == 12);
    CHECK(box.corners == 8);
    CHECK(box.smooth_edges == 0);
    CHECK(box.kinked_faces == 0);
    CHECK((box.centre_of_mass - geom::Vec3(2, 3.5, 5)).norm() < 1e-9);
    // m (b^2 + c^2) / 12 for mass 24.
    CHECK(box.principal_moments[0] == Approx(24.0 * (4 + 9) / 12.0));
    CHECK(box.principal_moments[1] == Approx(24.0 * (4 + 16) / 12.0));
    CHECK(box.principal_moments[2] == Approx(24.0 * (9 + 16) / 12.0));
    CHECK(box.edge_tolerance_mm == Approx(1e-7));
    CHECK_FALSE(box.open_gaps);
    CHECK(box.overlapping_solids.empty());

    const occ::CloseInspection cylinder =
        occ::inspect_closely(test::model_of(BRepPrimAPI_MakeCylinder(1.0, 3.0).Shape()));
    CHECK(cylinder.sharp_curves == 2);
    CHECK(cylinder.smooth_edges == 1);
    CHECK(cylinder.largest_kink_rad < 1e-6);
}

TEST_CASE("solids that reach into each other are named, neighbours are not", "[occ][oracle]") {
    const auto box = [](double x, double size) {
        return BRepPrimAPI_MakeBox(gp_Pnt(x, 0, 0), size, 10.0, 10.0).Shape();
    };
    TopoDS_Compound bodies;
    const BRep_Builder builder;
    builder.MakeCompound(bodies);
    builder.Add(bodies, box(0.0, 10.0));
    builder.Add(bodies, box(10.0, 10.0));  // touches the first
    builder.Add(bodies, box(19.9, 10.0));  // reaches into the second
    builder.Add(bodies, BRepPrimAPI_MakeSphere(gp_Pnt(5, 5, 5), 1.0).Shape());  // inside the first
    builder.Add(bodies, box(50.0, 10.0));
    const auto overlaps = occ::overlapping_solids(test::model_of(bodies));
    CHECK(overlaps == std::vector<std::array<int, 2>>{{0, 3}, {1, 2}});
}
