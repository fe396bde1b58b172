#include "occ/shapes.h"

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRep_Tool.hxx>
#include <Geom_Curve.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>
#include <gp_Pln.hxx>

using namespace patchwright;
using geom::FeatureKind;
using geom::FootPoint;
using geom::Vec3;
using occ::CadReference;

namespace {

CadReference reference_of(const TopoDS_Shape& shape) { return CadReference(test::model_of(shape)); }

}  // namespace

TEST_CASE("features of a box", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape());
    const auto edge = reference.feature_point(Vec3(-1, 7, -1), FeatureKind::Sharp);
    REQUIRE(edge.has_value());
    CHECK((edge->point - Vec3(0, 7, 0)).norm() < 1e-9);
    CHECK(edge->distance == Approx(std::sqrt(2.0)));
    const auto corner = reference.feature_point(Vec3(8, 18, 40), FeatureKind::Corner);
    REQUIRE(corner.has_value());
    CHECK((corner->point - Vec3(10, 20, 30)).norm() < 1e-9);
    CHECK_FALSE(reference.feature_point(Vec3::Zero(), FeatureKind::Free).has_value());
}

TEST_CASE("features of a cylinder: two rims, no seam, no corners", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeCylinder(5.0, 20.0).Shape());
    const auto rim = reference.feature_point(Vec3(9, 0, 9), FeatureKind::Sharp);
    REQUIRE(rim.has_value());
    CHECK((rim->point - Vec3(5, 0, 0)).norm() < 1e-9);
    CHECK_FALSE(reference.feature_point(Vec3::Zero(), FeatureKind::Corner).has_value());
    CHECK_FALSE(reference.feature_point(Vec3::Zero(), FeatureKind::Free).has_value());
}

TEST_CASE("a box filleted along one edge loses that feature", "[occ][oracle]") {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape();
    const auto along_z = [](const TopoDS_Edge& edge) {
        double a = 0, b = 0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, a, b);
        const gp_Pnt p = curve->Value(a), q = curve->Value(b);
        return p.X() < 1 && p.Y() < 1 && q.X() < 1 && q.Y() < 1;
    };
    BRepFilletAPI_MakeFillet fillet(box);
    for (TopExp_Explorer it(box, TopAbs_EDGE); it.More(); it.Next()) {
        if (along_z(TopoDS::Edge(it.Current()))) {
            fillet.Add(2.0, TopoDS::Edge(it.Current()));
            break;
        }
    }
    const CadReference reference = reference_of(fillet.Shape());
    const auto nearest = reference.feature_point(Vec3(0, 0, 15), FeatureKind::Sharp);
    REQUIRE(nearest.has_value());
    CHECK(nearest->distance == Approx(10.0).margin(1e-6));
    // The fillet's ends: two sharp edges meet smoothly there, so its vertices are no corners.
    const auto corner = reference.feature_point(Vec3(0, 0, 0), FeatureKind::Corner);
    REQUIRE(corner.has_value());
    CHECK(corner->distance == Approx(10.0).margin(1e-6));
}

TEST_CASE("an open face has free edges and corners", "[occ][oracle]") {
    const TopoDS_Shape face = BRepBuilderAPI_MakeFace(gp_Pln(), 0.0, 4.0, 0.0, 3.0).Face();
    const CadReference reference = reference_of(face);
    const auto edge = reference.feature_point(Vec3(1, -1, 1), FeatureKind::Free);
    REQUIRE(edge.has_value());
    CHECK((edge->point - Vec3(1, 0, 0)).norm() < 1e-9);
    const auto corner = reference.feature_point(Vec3(5, 4, 0), FeatureKind::Corner);
    REQUIRE(corner.has_value());
    CHECK((corner->point - Vec3(4, 3, 0)).norm() < 1e-9);
    CHECK_FALSE(reference.feature_point(Vec3::Zero(), FeatureKind::Sharp).has_value());
    const FootPoint beyond = reference.foot_point(Vec3(2, -3, 4));
    CHECK((beyond.point - Vec3(2, 0, 0)).norm() < 1e-9);
}
