// Healing of faces that do not hang together: what is closed, left out, turned, and said.
#include "occ/heal/heal.h"

#include "occ/exchange/iges_repair.h"
#include "occ/foot/tight_bounds.h"
#include "occ/heal/free_edge_gaps.h"
#include "occ/hull.h"
#include "occ/shapes.h"

#include <patchwright/occ/cad_reference.h>
#include <patchwright/occ/inspect.h>

#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>

#include <algorithm>
#include <random>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

/// The faces of a box of size 10 without common edges, each moved by `apart` times its number in a
/// direction of its own.
std::vector<TopoDS_Shape> loose_box(double apart) {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape();
    std::vector<TopoDS_Shape> faces;
    for (TopExp_Explorer it(box, TopAbs_FACE); it.More(); it.Next()) {
        gp_Trsf move;
        const int n = int(faces.size());
        move.SetTranslation(apart * gp_Vec(n % 2, n % 3 - 1, n % 4 - 1.5));
        faces.push_back(BRepBuilderAPI_Transform(it.Current(), move, true).Shape());
    }
    return faces;
}

TopoDS_Shape compound(const std::vector<TopoDS_Shape>& shapes) {
    const BRep_Builder builder;
    TopoDS_Compound result;
    builder.MakeCompound(result);
    for (const TopoDS_Shape& shape : shapes) builder.Add(result, shape);
    return result;
}

struct Healed {
    occ::ReadReport report;
    occ::Inspection found;
};

Healed heal(const std::vector<TopoDS_Shape>& shapes) {
    Healed result;
    occ::FaceOrigins origins;
    const TopoDS_Shape whole = compound(shapes);
    const double size = occ::tight_bounds(whole).diagonal();
    result.found =
        occ::inspect(test::model_of(occ::heal(whole, size, 1e-3, result.report, origins)));
    return result;
}

}  // namespace

TEST_CASE("the gaps between loose faces are measured", "[occ][heal][oracle]") {
    // Two unit squares side by side, 0.01 apart.
    const TopoDS_Shape a = BRepBuilderAPI_MakeFace(gp_Pln(), 0.0, 1.0, 0.0, 1.0).Face();
    const TopoDS_Shape b = BRepBuilderAPI_MakeFace(gp_Pln(), 1.01, 2.01, 0.0, 1.0).Face();
    const std::vector<double> gaps = occ::free_edge_gaps(compound({a, b}));
    REQUIRE(gaps.size() == 8);
    CHECK(gaps[0] == Approx(0.01));
    CHECK(gaps[1] == Approx(0.01));
    // The others are nearest to their neighbours around the corner, half of their length away.
    CHECK(gaps[2] == Approx(0.5).epsilon(0.1));
    CHECK(occ::free_edge_gaps(BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape()).empty());
}

TEST_CASE("sewing takes the tolerance that the gaps ask for", "[occ][heal]") {
    const double diagonal = std::sqrt(300.0);
    for (const double apart : {0.0, 1e-5, 3e-4, 2e-3}) {
        CAPTURE(apart);
        const Healed box = heal(loose_box(apart));
        CHECK(box.found.solids == 1);
        CHECK(box.found.volume_mm3 == Approx(1000.0).epsilon(10 * apart + 1e-9));
        REQUIRE(box.report.sewn);
        CHECK(box.report.sewn->tolerance_mm <= 12.0 * apart + 1e-6);
        // Gaps above 1e-4 of the diagonal are worth a word.
        const bool large = box.report.sewn->tolerance_mm > 1e-4 * diagonal;
        CHECK(box.report.notices.size() == (large ? 1 : 0));
    }
    // Larger gaps are closed only if that closes the body: here a face is missing.
    auto open = loose_box(2e-3);
    open.pop_back();
    const Healed still = heal(open);
    if (still.report.sewn) CHECK(still.report.sewn->tolerance_mm <= 1e-4 * diagonal);
    CHECK(still.found.free_edges > 4);
    REQUIRE_FALSE(still.report.notices.empty());
    CHECK_THAT(still.report.notices.front(), Contains("stay open"));
}

TEST_CASE("sides as short as the gaps are points", "[occ][heal]") {
    // All waterlines end in one place, but for the gaps.
    constexpr int stations = 4, waterlines = 12;
    for (const double gap_mm : {0.0, 0.01}) {
        const auto faces = test::hull_faces(stations, waterlines, gap_mm);
        const Healed hull = heal({faces.begin(), faces.end()});
        CHECK(hull.found.shells_open == 1);
        CHECK(hull.found.faces == stations * waterlines);
        CHECK(hull.found.valid);
        // The stern, the keel and the deck.
        CHECK(hull.found.free_edges == waterlines + 2 * stations);
    }
}

TEST_CASE("solids that touch in a wall stay two, whatever the order of their faces",
          "[occ][heal]") {
    const auto moved = [](const TopoDS_Shape& shape, double x, double z) {
        gp_Trsf move;
        move.SetTranslation(gp_Vec(x, 0, z));
        return BRepBuilderAPI_Transform(shape, move, true).Shape();
    };
    const auto loose = [](const TopoDS_Shape& shape, std::vector<TopoDS_Shape>& faces) {
        for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
            faces.push_back(BRepBuilderAPI_Copy(it.Current()).Shape());
    };
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape();
    struct Case {
        std::string name;
        std::vector<TopoDS_Shape> faces;
        int solids;
        double volume;
    };
    std::vector<Case> cases;
    cases.push_back({"boxes", {}, 2, 2000.0});
    loose(box, cases.back().faces);
    loose(moved(box, 10, 0), cases.back().faces);
    cases.push_back({"a solid and loose faces", {box}, 2, 2000.0});
    loose(moved(box, 10, 0), cases.back().faces);
    // Nine faces a side: that in the middle of the wall has no neighbours but the others of the
    // wall.
    cases.push_back({"boxes with nine faces a side", {}, 2, 2000.0});
    for (const double x : {0.0, 10.0}) {
        for (const gp_Dir& out : {gp::DX(), gp::DY(), gp::DZ()}) {
            for (const double side : {0.0, 10.0}) {
                const gp_Dir along = out.IsEqual(gp::DX(), 0.1) ? gp::DY() : gp::DX();
                const gp_Ax3 axes(gp_Pnt(x, 0, 0).Translated(side * gp_Vec(out)), out, along);
                const double up = out.IsEqual(gp::DY(), 0.1) ? -10.0 : 0.0;
                const double third = 10.0 / 3;
                for (int k = 0; k < 9; ++k) {
                    const double u = third * (k % 3), v = up + third * (k / 3);
                    cases.back().faces.push_back(
                        BRepBuilderAPI_MakeFace(gp_Pln(axes), u, u + third, v, v + third).Face());
                }
            }
        }
    }
    // Four faces meet in one edge.
    cases.push_back({"an edge only", {}, 2, 2000.0});
    loose(box, cases.back().faces);
    loose(moved(box, 10, 10), cases.back().faces);
    // Cylinders in halves: the lower one's lid is two halves of a disc, the upper one's is one
    // disc.
    cases.push_back({"cylinders", {}, 2, 250.0 * M_PI});
    for (const double angle : {0.0, M_PI}) {
        const gp_Ax2 lower(gp_Pnt(0, 0, 0), gp::DZ(), gp_Dir(std::cos(angle), std::sin(angle), 0)),
            upper = lower.Translated(gp_Vec(0, 0, 5));
        for (const gp_Ax2& axes : {lower, upper}) {
            const TopoDS_Shape half = BRepPrimAPI_MakeCylinder(axes, 5.0, 5.0, M_PI).Shape();
            for (TopExp_Explorer it(half, TopAbs_FACE); it.More(); it.Next()) {
                GProp_GProps area;
                BRepGProp::SurfaceProperties(it.Current(), area);
                const gp_Pnt middle = area.CentreOfMass();
                const bool cut = std::abs(middle.Y()) < 1e-6;
                const bool lid_above = middle.Z() < 5.0 + 1e-6 && axes.Location().Z() > 0.0;
                if (!cut && !lid_above) cases.back().faces.push_back(it.Current());
            }
        }
    }
    const gp_Ax2 lid(gp_Pnt(0, 0, 5), gp::DZ());
    BRepBuilderAPI_MakeWire rim;
    for (const double from : {0.0, M_PI})
        rim.Add(BRepBuilderAPI_MakeEdge(gp_Circ(lid, 5.0), from, from + M_PI).Edge());
    cases.back().faces.push_back(BRepBuilderAPI_MakeFace(gp_Pln(gp_Ax3(lid)), rim.Wire()).Face());
    cases.push_back({"a box that is there twice", {}, 1, 1000.0});
    loose(box, cases.back().faces);
    loose(box, cases.back().faces);
    std::mt19937 random(3);  // NOLINT(cert-msc51-cpp): the same on every run
    for (Case& at : cases) {
        for (int order = 0; order < 20; ++order) {
            CAPTURE(at.name, order);
            const Healed touching = heal(at.faces);
            CHECK(touching.found.solids == at.solids);
            CHECK(touching.found.valid);
            CHECK(touching.found.volume_mm3 == Approx(at.volume));
            std::shuffle(at.faces.begin(), at.faces.end(), random);
        }
    }
}

TEST_CASE("faces that are there twice and faces without width are left out", "[occ][heal]") {
    auto faces = loose_box(0.0);
    faces.push_back(BRepBuilderAPI_Copy(faces[2]).Shape());
    faces.push_back(BRepBuilderAPI_Copy(faces[4]).Shape().Reversed());
    faces.push_back(BRepBuilderAPI_MakeFace(gp_Pln(), 0.0, 10.0, 0.0, 1e-6).Face());
    const Healed box = heal(faces);
    CHECK(box.report.duplicates_dropped == 2);
    CHECK(box.report.slivers_dropped == 1);
    CHECK(box.found.faces == 6);
    CHECK(box.found.solids == 1);
    CHECK(box.found.volume_mm3 == Approx(1000.0));
    REQUIRE_FALSE(box.report.notices.empty());
    CHECK_THAT(box.report.notices.front(), Contains("2 faces that lie on others and 1 without"));

    // The same faces somewhere else are no duplicates, nor is the other half of a cylinder.
    auto two = loose_box(0.0);
    for (const TopoDS_Shape& face : loose_box(0.0)) {
        gp_Trsf move;
        move.SetTranslation(gp_Vec(20, 0, 0));
        two.push_back(BRepBuilderAPI_Transform(face, move, true).Shape());
    }
    CHECK(heal(two).found.solids == 2);
}

TEST_CASE("faces that look the wrong way are turned and counted", "[occ][heal]") {
    auto faces = loose_box(0.0);
    for (const std::size_t i : {0u, 3u}) faces[i].Reverse();
    const Healed some = heal(faces);
    CHECK(some.report.faces_turned == 2);
    CHECK(some.found.volume_mm3 == Approx(1000.0));
    const Healed inside_out = heal({BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape().Reversed()});
    CHECK(inside_out.found.volume_mm3 == Approx(1.0));
    CHECK(inside_out.report.faces_turned == 6);
}

TEST_CASE("records that end in column 65 are moved left", "[occ][heal]") {
    const auto record = [](std::string data, char section, int number) {
        data.resize(72, ' ');
        std::string tail = std::to_string(number);
        tail.insert(0, 7 - tail.size(), ' ');
        return data + section + tail + "\n";
    };
    const std::string head = record("", 'S', 1) + record("1H,,1H;,4Htest;", 'G', 1);
    const auto fields = [](int count) {
        std::string data;
        for (int i = 0; i < count; ++i) data += "           3,";
        return data;
    };
    const std::string bad = head + record(fields(5), 'P', 1) + record("  0.5;", 'P', 2);
    const auto repair = occ::repair_iges(bad);
    REQUIRE(repair.has_value());
    CHECK(repair->text == head + record(fields(5).substr(1), 'P', 1) + record("  0.5;", 'P', 2));
    CHECK(repair->notices.size() == 1);
    // Nothing to repair; and nothing that can be: within a string blanks count.
    CHECK_FALSE(occ::repair_iges(head + record(fields(4), 'P', 1)).has_value());
    CHECK_FALSE(
        occ::repair_iges(head + record("406,70H", 'P', 1) + record(fields(5), 'P', 2)).has_value());
}

TEST_CASE("p-curves that swing out between the places of checks follow their edges",
          "[occ][heal]") {
    // A square face whose p-curve of one side leaves the side for a hundredth of its length: the
    // kernel compares the two curves in fewer points than that.
    const double side = 10.0, swing = 0.3;
    const auto square = [&](double out) {
        const TopoDS_Face face = BRepBuilderAPI_MakeFace(gp_Pln(), 0.0, side, 0.0, side).Face();
        for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
            const TopoDS_Edge edge = TopoDS::Edge(it.Current());
            double first = 0, last = 0;
            const Handle(Geom2d_Curve) old = BRep_Tool::CurveOnSurface(edge, face, first, last);
            if (std::abs(old->Value(first).Y() - side) > 1e-9 ||
                std::abs(old->Value(last).Y() - side) > 1e-9)
                continue;
            const std::vector<double> shares{0.0, 0.412, 0.415, 0.419, 0.422, 1.0};
            TColgp_Array1OfPnt2d poles(1, int(shares.size()));
            TColStd_Array1OfReal knots(1, int(shares.size()));
            TColStd_Array1OfInteger multiplicities(1, int(shares.size()));
            multiplicities.Init(1);
            multiplicities(1) = multiplicities(int(shares.size())) = 2;
            for (std::size_t i = 0; i < shares.size(); ++i) {
                const double t = first + shares[i] * (last - first);
                const bool swings = i == 2 || i == 3;
                poles(int(i) + 1) = old->Value(t).Translated({0.0, swings ? out : 0.0});
                knots(int(i) + 1) = t;
            }
            BRep_Builder().UpdateEdge(
                edge, new Geom2d_BSplineCurve(poles, knots, multiplicities, 1), face, 1e-7);
            return face;
        }
        throw std::logic_error("the square has no such side");
    };
    const geom::Vec3 swung_to(0.4171 * side, side + 0.9 * swing, 0.0);
    const auto distance = [&](const TopoDS_Shape& shape) {
        return occ::CadReference(test::model_of(shape)).foot_point(swung_to).distance;
    };
    CHECK(distance(square(swing)) == Approx(0.0).margin(1e-9));  // what the face is as it comes

    occ::ReadReport report;
    occ::FaceOrigins origins;
    const TopoDS_Shape healed = occ::heal(square(swing), side * M_SQRT2, 1e-3, report, origins, {});
    CHECK(report.pcurves_projected == 1);
    CHECK(distance(healed) == Approx(0.9 * swing));
    REQUIRE(report.notices.size() >= 1);
    CHECK_THAT(report.notices[0], Contains("1 trimming curves left their edges"));
    CHECK(occ::inspect(test::model_of(healed)).valid);

    // Within a quarter of the default tolerance nothing is touched.
    occ::ReadReport untouched;
    static_cast<void>(occ::heal(square(2e-4), side * M_SQRT2, 1e-3, untouched, origins, {}));
    CHECK(untouched.pcurves_projected == 0);
}
