// Holes that are narrower than what matters: which are closed, which stay, and what is left.
#include "occ/exchange/cad_model_impl.h"
#include "occ/shapes.h"

#include <patchwright/occ/inspect.h>
#include <patchwright/occ/narrow_holes.h>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <catch2/catch.hpp>
#include <gp_Ax2.hxx>

#include <algorithm>

using namespace patchwright;

namespace {

constexpr double size = 10.0;

TopoDS_Shape box() { return BRepPrimAPI_MakeBox(size, size, size).Shape(); }

/// Along a direction from a point.
TopoDS_Shape cylinder(const gp_Pnt& from, const gp_Dir& along, double diameter, double length) {
    return BRepPrimAPI_MakeCylinder(gp_Ax2(from, along), 0.5 * diameter, length).Shape();
}

TopoDS_Shape cut(const TopoDS_Shape& from, const TopoDS_Shape& what) {
    return BRepAlgoAPI_Cut(from, what).Shape();
}

occ::ModelWithoutHoles close(const TopoDS_Shape& shape, double width) {
    return occ::without_narrow_holes(test::model_of(shape), width);
}

/// The box again, whole.
void check_box(const occ::CadModel& model) {
    const occ::Inspection found = occ::inspect(model);
    CHECK(found.solids == 1);
    CHECK(found.faces == 6);
    CHECK(found.edges == 12);
    CHECK(found.closed);
    CHECK(found.valid);
    CHECK(found.volume_mm3 == Approx(size * size * size).epsilon(1e-12));
}

}  // namespace

TEST_CASE("narrow holes: through holes are closed, straight and slanted") {
    for (const gp_Dir& along : {gp_Dir(0, 0, 1), gp_Dir(0.3, 0.2, 1), gp_Dir(-0.5, 0, 1)}) {
        const gp_Pnt from(5 - 8 * along.X(), 5 - 8 * along.Y(), 5 - 8 * along.Z());
        // The rim of a slanted hole is an ellipse.
        const double width = 0.1 / along.Z();
        const auto drilled = cut(box(), cylinder(from, along, 0.1, 20));
        const auto [model, holes] = close(drilled, 1.01 * width);
        REQUIRE(holes.size() == 1);
        CHECK(holes[0].faces == 1);
        CHECK(holes[0].width_mm == Approx(width).epsilon(0.01));
        CHECK(std::abs(holes[0].at.z() - 5) == Approx(5));
        check_box(model);
        CHECK(close(drilled, 0.97 * width).holes.empty());
    }
}

TEST_CASE("narrow holes: blind holes and holes that bend are closed") {
    const TopoDS_Shape blind = cylinder(gp_Pnt(3, 3, 4), gp_Dir(0, 0, 1), 0.1, 10);
    const TopoDS_Shape bent =
        BRepAlgoAPI_Fuse(cylinder(gp_Pnt(7, 7, 4), gp_Dir(0, 0, 1), 0.1, 10),
                         cylinder(gp_Pnt(7, 7, 4.2), gp_Dir(1, 0, 0), 0.08, 10))
            .Shape();
    const auto [model, holes] = close(cut(cut(box(), blind), bent), 0.2);
    REQUIRE(holes.size() == 2);
    CHECK(holes[0].faces == 2);
    CHECK(holes[1].faces >= 3);
    check_box(model);
}

TEST_CASE("narrow holes: what is wide inside stays, and so does a pin") {
    const TopoDS_Shape cavity = BRepPrimAPI_MakeBox(gp_Pnt(3, 3, 3), 4.0, 4.0, 4.0).Shape();
    const TopoDS_Shape channel = cylinder(gp_Pnt(5, 5, 6), gp_Dir(0, 0, 1), 0.1, 10);
    CHECK(close(cut(cut(box(), cavity), channel), 0.2).holes.empty());
    const gp_Ax2 up(gp_Pnt(5, 5, 5), gp_Dir(0, 0, 1));
    const TopoDS_Shape flask = BRepPrimAPI_MakeCone(up, 2.0, 0.05, 5.0).Shape();
    CHECK(close(cut(box(), flask), 0.2).holes.empty());
    const TopoDS_Shape pin = cylinder(gp_Pnt(5, 5, 9), gp_Dir(0, 0, 1), 0.1, 3);
    CHECK(close(BRepAlgoAPI_Fuse(box(), pin).Shape(), 0.2).holes.empty());
}

TEST_CASE("narrow holes: a hole in a sheet is closed") {
    const TopoDS_Shape drilled = cut(box(), cylinder(gp_Pnt(5, 5, -1), gp_Dir(0, 0, 1), 0.1, 20));
    for (TopExp_Explorer it(drilled, TopAbs_FACE); it.More(); it.Next()) {
        const auto before = occ::inspect(test::model_of(it.Current()));
        const auto [model, holes] = close(it.Current(), 0.2);
        const bool has_hole = before.edges == 5;
        CHECK(holes.size() == (has_hole ? 1 : 0));
        if (!has_hole) continue;
        CHECK(holes[0].faces == 0);
        CHECK(occ::inspect(model).area_mm2 == Approx(size * size).epsilon(1e-12));
    }
}

TEST_CASE("narrow holes: faces that stay keep their names and colours") {
    auto impl = std::make_shared<occ::CadModel::Impl>();
    impl->shape = cut(box(), cylinder(gp_Pnt(5, 5, -1), gp_Dir(0, 0, 1), 0.1, 20));
    const occ::CadModel plain(impl);
    const auto boxes = occ::faces_of(plain);
    for (std::size_t f = 0; f < boxes.size(); ++f) {
        impl->face_names.push_back("face " + std::to_string(f));
        impl->face_colours.emplace_back(occ::Colour{1.0F, 0.1F * float(f), 0.0F});
    }
    const auto [model, holes] = occ::without_narrow_holes(plain, 0.2);
    REQUIRE(holes.size() == 1);
    std::vector<std::string> names = occ::face_names(model);
    REQUIRE(names.size() == 6);
    std::sort(names.begin(), names.end());
    CHECK(std::unique(names.begin(), names.end()) == names.end());
    CHECK(std::find(names.begin(), names.end(), "") == names.end());
    for (const auto& colour : occ::face_colours(model)) CHECK(colour.has_value());
}
