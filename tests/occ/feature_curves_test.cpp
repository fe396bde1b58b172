#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/cad_reference.h>

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>
#include <gp_Circ.hxx>
#include <gp_Elips.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>

using namespace patchwright;
using geom::ArcRange;
using geom::CornerKind;
using geom::FeatureCurve;
using geom::FeatureKind;
using geom::FeaturePoint;
using geom::Vec3;
using occ::CadReference;

namespace {

CadReference reference_of(const TopoDS_Shape& shape) { return CadReference(test::model_of(shape)); }

std::vector<int> curves_of_kind(const CadReference& reference, FeatureKind kind) {
    std::vector<int> result;
    const auto& curves = reference.features().curves;
    for (std::size_t i = 0; i < curves.size(); ++i)
        if (curves[i].kind == kind) result.push_back(int(i));
    return result;
}

TopoDS_Face plane_face(const TopoDS_Wire& wire) { return BRepBuilderAPI_MakeFace(wire, true); }

TopoDS_Edge arc(const gp_Pnt& from, const gp_Pnt& over, const gp_Pnt& to) {
    return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(from, over, to).Value());
}

}  // namespace

TEST_CASE("feature curves of a box run from corner to corner", "[occ][features][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape());
    const geom::Features& features = reference.features();
    REQUIRE(features.curves.size() == 12);
    REQUIRE(features.corners.size() == 8);
    for (const FeatureCurve& curve : features.curves) {
        CHECK(curve.kind == FeatureKind::Sharp);
        CHECK_FALSE(curve.closed);
        CHECK(curve.length == Approx((curve.end - curve.start).norm()).epsilon(1e-12));
        CHECK(curve.least_angle_rad == Approx(M_PI / 2));
        CHECK(curve.greatest_angle_rad == Approx(M_PI / 2));
        REQUIRE(curve.start_corner >= 0);
        REQUIRE(curve.end_corner >= 0);
        CHECK((features.corners[std::size_t(curve.start_corner)].point - curve.start).norm() <
              1e-9);
        CHECK((features.corners[std::size_t(curve.end_corner)].point - curve.end).norm() < 1e-9);
    }
    for (const auto& corner : features.corners) {
        CHECK(corner.kind == CornerKind::Junction);
        CHECK(corner.curves.size() == 3);
    }
    const auto hit = reference.feature_point(Vec3(-1, 7, -1), FeatureKind::Sharp);
    REQUIRE(hit.has_value());
    CHECK(std::abs(hit->tangent.y()) == Approx(1.0));
    const FeaturePoint same = reference.point_on_curve(hit->feature, hit->arc_length);
    CHECK((same.point - Vec3(0, 7, 0)).norm() < 1e-9);
}

TEST_CASE("an edge that is sharp on part of its length is cut there", "[occ][features][oracle]") {
    // A flat strip beside z = x y, which leaves it at the angle atan(x).
    TColgp_Array2OfPnt flat(1, 2, 1, 2), twisted(1, 2, 1, 2);
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            flat.SetValue(i + 1, j + 1, gp_Pnt(i, j - 1, 0));
            twisted.SetValue(i + 1, j + 1, gp_Pnt(i, j, i * j));
        }
    }
    BRepBuilderAPI_Sewing sewing(1e-6);
    for (const auto& poles : {flat, twisted})
        sewing.Add(BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-7).Shape());
    sewing.Perform();
    const occ::CadModel model = test::model_of(sewing.SewedShape());
    const CadReference reference(model);
    const auto sharp = curves_of_kind(reference, FeatureKind::Sharp);
    const auto smooth = curves_of_kind(reference, FeatureKind::Smooth);
    REQUIRE(sharp.size() == 1);
    REQUIRE(smooth.size() == 1);
    const geom::Features& features = reference.features();
    const double change = std::tan(occ::ReferenceOptions{}.sharp_angle_rad);
    CHECK(features.curves[std::size_t(sharp[0])].length == Approx(1.0 - change).epsilon(1e-6));
    CHECK(features.curves[std::size_t(smooth[0])].length == Approx(change).epsilon(1e-6));
    const auto hit = reference.feature_point(Vec3(0.1, 0, 0), FeatureKind::Sharp);
    REQUIRE(hit.has_value());
    CHECK((hit->point - Vec3(change, 0, 0)).norm() < 1e-6);
    const auto ends = std::count_if(
        features.corners.begin(), features.corners.end(), [&](const geom::FeatureCorner& corner) {
            return corner.kind == CornerKind::End && (corner.point - hit->point).norm() < 1e-6;
        });
    CHECK(ends == 1);

    // The model's triangles have both pieces too, and a corner between them, however coarse or
    // fine.
    for (const double deflection : {1.0, 1e-2, 1e-4}) {
        const geom::SurfaceMesh mesh = reference.surface_mesh(deflection);
        std::map<int, double> length;
        std::map<std::pair<int, int>, int> triangles;
        double area = 0.0;
        for (const geom::FeatureSide& side : mesh.features)
            length[side.curve] += (mesh.points.row(side.v0) - mesh.points.row(side.v1)).norm();
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.points.row(t[0]), b = mesh.points.row(t[1]),
                       c = mesh.points.row(t[2]);
            area += 0.5 * (b - a).cross(c - a).norm();
            for (std::size_t k = 0; k < 3; ++k) ++triangles[std::minmax(t[k], t[(k + 1) % 3])];
        }
        CHECK(length[sharp[0]] == Approx(1.0 - change).epsilon(1e-6));
        CHECK(length[smooth[0]] == Approx(change).epsilon(1e-6));
        for (const geom::FeatureSide& side : mesh.features)
            if (side.curve == sharp[0] || side.curve == smooth[0])
                CHECK(triangles[{side.v0, side.v1}] == 2);
        const auto corner = std::count_if(
            features.corners.begin(), features.corners.end(), [&](const auto& candidate) {
                const auto number = int(&candidate - features.corners.data());
                const auto at = std::find(mesh.corners.begin(), mesh.corners.end(), number);
                return at != mesh.corners.end() &&
                       (mesh.points.row(at - mesh.corners.begin()).transpose() - hit->point)
                               .norm() < 1e-6;
            });
        CHECK(corner == 1);
        // Flat strip 1; z = x y over the unit square: 1.2807 (by quadrature), chords take some.
        CHECK(area == Approx(2.2807).epsilon(0.1));
    }
}

TEST_CASE("a rim of a cylinder is one closed curve", "[occ][features][oracle]") {
    constexpr double radius = 5.0;
    const CadReference reference = reference_of(BRepPrimAPI_MakeCylinder(radius, 20.0).Shape());
    CHECK(reference.features().corners.empty());
    const auto rims = curves_of_kind(reference, FeatureKind::Sharp);
    REQUIRE(rims.size() == 2);
    CHECK(curves_of_kind(reference, FeatureKind::Smooth).size() == 1);  // the seam
    for (const int rim : rims) {
        const FeatureCurve& curve = reference.features().curves[std::size_t(rim)];
        CHECK(curve.closed);
        CHECK(curve.start_corner == -1);
        CHECK(curve.length == Approx(2 * M_PI * radius).epsilon(1e-12));
        const Vec3 centre(0, 0, curve.start.z()), axis(0, 0, 1);
        const Vec3 x = (curve.start - centre) / radius;
        const Vec3 y = reference.point_on_curve(rim, 0.0).tangent;
        CHECK(std::abs(x.cross(y).dot(axis)) == Approx(1.0));
        for (const double s : {-4.0, 0.0, 1.0, 12.0, 31.0, 40.0}) {
            const double angle = s / radius;
            const FeaturePoint p = reference.point_on_curve(rim, s);
            CAPTURE(s);
            CHECK((p.point - centre - radius * (std::cos(angle) * x + std::sin(angle) * y)).norm() <
                  1e-9);
            CHECK((p.tangent - std::cos(angle) * y + std::sin(angle) * x).norm() < 1e-9);
            const FeaturePoint foot =
                reference.nearest_on_curve(rim, p.point + 2.0 * (p.point - centre) / radius);
            CHECK(foot.distance == Approx(2.0));
            CHECK(std::cos((foot.arc_length - s) / radius) == Approx(1.0).epsilon(1e-12));
        }
        // Only the piece that runs across the start counts.
        const double length = curve.length;
        const Vec3 query = reference.point_on_curve(rim, 0.5 * length).point;
        const FeaturePoint held =
            reference.nearest_on_curve(rim, query, ArcRange{0.9 * length, 1.2 * length});
        CHECK((held.point - reference.point_on_curve(rim, 0.2 * length).point).norm() < 1e-9);
        const FeaturePoint free =
            reference.nearest_on_curve(rim, reference.point_on_curve(rim, 0.05 * length).point,
                                       ArcRange{-0.1 * length, 0.2 * length});
        CHECK(free.distance < 1e-9);
        CHECK(free.arc_length == Approx(0.05 * length));
    }
}

TEST_CASE("arc length of an ellipse", "[occ][features][oracle]") {
    const gp_Elips ellipse(gp_Ax2(), 5.0, 2.0);
    const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(ellipse);
    const CadReference reference = reference_of(plane_face(BRepBuilderAPI_MakeWire(edge)));
    const auto curves = curves_of_kind(reference, FeatureKind::Free);
    REQUIRE(curves.size() == 1);
    const double eccentricity = std::sqrt(1.0 - 4.0 / 25.0);
    CHECK(reference.features().curves.front().length ==
          Approx(4 * 5.0 * std::comp_ellint_2(eccentricity)).epsilon(1e-11));
    // A quarter of the way is a quarter of the angle by symmetry.
    const Vec3 quarter =
        reference.point_on_curve(0, 0.25 * reference.features().curves.front().length).point;
    CHECK(std::min((quarter - Vec3(0, 2, 0)).norm(), (quarter + Vec3(0, 2, 0)).norm()) < 1e-9);
}

TEST_CASE("edges that go straight on are chained, turns are corners", "[occ][features][oracle]") {
    SECTION("two half circles") {
        BRepBuilderAPI_MakeWire wire(arc(gp_Pnt(1, 0, 0), gp_Pnt(0, 1, 0), gp_Pnt(-1, 0, 0)),
                                     arc(gp_Pnt(-1, 0, 0), gp_Pnt(0, -1, 0), gp_Pnt(1, 0, 0)));
        const CadReference reference = reference_of(plane_face(wire.Wire()));
        REQUIRE(reference.features().curves.size() == 1);
        CHECK(reference.features().curves[0].closed);
        CHECK(reference.features().curves[0].length == Approx(2 * M_PI));
        CHECK(reference.features().corners.empty());
    }
    SECTION("a half disc has two corners") {
        BRepBuilderAPI_MakeWire wire(
            arc(gp_Pnt(1, 0, 0), gp_Pnt(0, 1, 0), gp_Pnt(-1, 0, 0)),
            BRepBuilderAPI_MakeEdge(gp_Pnt(-1, 0, 0), gp_Pnt(1, 0, 0)).Edge());
        const CadReference reference = reference_of(plane_face(wire.Wire()));
        CHECK(reference.features().curves.size() == 2);
        REQUIRE(reference.features().corners.size() == 2);
        CHECK(reference.features().corners[0].kind == CornerKind::Junction);
    }
    SECTION("a drop with a tip without an opening has a cusp") {
        // The arc and the line both leave the origin along x.
        BRepBuilderAPI_MakeWire wire(
            arc(gp_Pnt(0, 0, 0), gp_Pnt(1, 2 - std::sqrt(3.0), 0), gp_Pnt(2, 2, 0)),
            BRepBuilderAPI_MakeEdge(gp_Pnt(2, 2, 0), gp_Pnt(4, 0, 0)));
        wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(4, 0, 0), gp_Pnt(0, 0, 0)).Edge());
        const CadReference reference = reference_of(plane_face(wire.Wire()));
        int cusps = 0;
        for (const auto& corner : reference.features().corners) {
            if (corner.kind != CornerKind::Cusp) continue;
            ++cusps;
            CHECK(corner.point.norm() < 1e-9);
        }
        CHECK(cusps == 1);
    }
    SECTION("the tip of a cone is an apex") {
        const CadReference reference = reference_of(BRepPrimAPI_MakeCone(5.0, 0.0, 12.0).Shape());
        REQUIRE(reference.features().corners.size() == 1);
        CHECK(reference.features().corners[0].kind == CornerKind::Apex);
        CHECK((reference.features().corners[0].point - Vec3(0, 0, 12)).norm() < 1e-9);
        CHECK(reference.features().corners[0].curves.empty());
    }
}

TEST_CASE("points of feature curves are found again", "[occ][features][oracle]") {
    const CadReference reference = reference_of(test::wing());
    std::mt19937 random(1);
    std::uniform_real_distribution<double> share;
    const auto& curves = reference.features().curves;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        for (int k = 0; k < 20; ++k) {
            const double s = share(random) * curves[i].length;
            const FeaturePoint p = reference.point_on_curve(int(i), s);
            const FeaturePoint foot = reference.nearest_on_curve(int(i), p.point);
            CAPTURE(i, s);
            CHECK(foot.distance < 1e-9);
            CHECK(foot.arc_length == Approx(s).margin(1e-6));
            // A piece around it holds the same point; one beside it ends nearer to it than it
            // starts.
            const ArcRange around{std::max(0.0, s - 1.0), std::min(curves[i].length, s + 1.0)};
            CHECK(reference.nearest_on_curve(int(i), p.point, around).distance < 1e-9);
            const FeaturePoint before =
                reference.nearest_on_curve(int(i), p.point, ArcRange{0.0, 0.999 * s});
            CHECK(before.arc_length <= 0.999 * s + 1e-9);
        }
    }
    // The nearest curve of a kind is the nearest of all its curves.
    for (int k = 0; k < 100; ++k) {
        const Vec3 q(150 * share(random) - 20, 40 * share(random) - 20, 340 * share(random) - 20);
        const auto nearest = reference.feature_point(q, FeatureKind::Sharp);
        REQUIRE(nearest.has_value());
        double expected = 1e30;
        for (const int c : curves_of_kind(reference, FeatureKind::Sharp))
            expected = std::min(expected, reference.nearest_on_curve(c, q).distance);
        CHECK(nearest->distance == Approx(expected).margin(1e-9));
    }
}

TEST_CASE("curves that are not there are refused", "[occ][features]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape());
    CHECK_THROWS_AS(reference.nearest_on_curve(12, Vec3::Zero()), base::InvalidArgument);
    CHECK_THROWS_AS(reference.point_on_curve(-1, 0.0), base::InvalidArgument);
    CHECK_THROWS_AS(reference.nearest_on_curve(0, Vec3::Zero(), ArcRange{0.5, 0.4}),
                    base::InvalidArgument);
}
