#include "occ/near_points.h"
#include "occ/odd_shapes.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <random>

using namespace patchwright;
using geom::FootPoint;
using geom::Vec3;
using occ::CadReference;
using test::near_points;

namespace {

CadReference reference_of(const TopoDS_Shape& shape, const occ::ReferenceOptions& options = {}) {
    return CadReference(test::model_of(shape), options);
}

std::vector<Vec3> random_points(const geom::Box3& around, double grow, int count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-0.5 - grow, 0.5 + grow);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const Vec3 s(unit(random), unit(random), unit(random));
        points.push_back(around.centre() + s.cwiseProduct(around.max - around.min));
    }
    return points;
}

void check_against_kernel(const TopoDS_Shape& shape, int count, unsigned seed) {
    const CadReference reference = reference_of(shape);
    const TopoDS_Compound faces = test::faces_only(shape);
    const double size = reference.bounds().diagonal();
    auto points = random_points(reference.bounds(), 0.3, count, seed);
    for (const Vec3& p : near_points(reference, 0.02 * size, count, seed + 1)) points.push_back(p);
    for (const Vec3& p : near_points(reference, 0.0, count / 4, seed + 2)) points.push_back(p);
    for (const Vec3& p : random_points(reference.bounds(), 30.0, count / 8, seed + 3))
        points.push_back(p);
    for (const Vec3& p : points) {
        const FootPoint foot = reference.foot_point(p);
        const double expected = test::kernel_distance(faces, p);
        CAPTURE(p.transpose(), foot.point.transpose(), foot.face);
        // The kernel itself may miss minima; ours may not be farther.
        CHECK(foot.distance <= expected + 2e-7 + 1e-9 * size);
        CHECK(test::kernel_distance(faces, foot.point) <= 2e-7 + 1e-9 * size);
        CHECK((foot.point - p).norm() == Approx(foot.distance).margin(1e-12 * size));
    }
}

}  // namespace

TEST_CASE("foot points on a sphere are radial, inside and outside", "[occ][oracle]") {
    const bool as_bspline = GENERATE(false, true);
    const Vec3 centre(1, 2, 3);
    TopoDS_Shape sphere = BRepPrimAPI_MakeSphere(gp_Pnt(1, 2, 3), 5.0).Shape();
    if (as_bspline) sphere = BRepBuilderAPI_NurbsConvert(sphere).Shape();
    const CadReference reference = reference_of(sphere);
    for (const Vec3& p : random_points(reference.bounds(), 1.0, 400, 1)) {
        const Vec3 radial = (p - centre).normalized();
        const FootPoint foot = reference.foot_point(p);
        CAPTURE(p.transpose());
        CHECK(foot.distance == Approx(std::abs((p - centre).norm() - 5.0)).margin(1e-10));
        CHECK((foot.point - centre - 5.0 * radial).norm() < 1e-7);
        CHECK((foot.normal - radial).norm() < 1e-7);
        CHECK(foot.face == 0);
    }
    for (const double z : {-20.0, -1.0, 2.0, 9.0}) {
        // On the axis, over the poles.
        const FootPoint foot = reference.foot_point(centre + Vec3(0, 0, z));
        CHECK(foot.distance == Approx(std::abs(std::abs(z) - 5.0)).margin(1e-10));
        CHECK((foot.normal - Vec3(0, 0, z > 0 ? 1 : -1)).norm() < 1e-4);
    }
    CHECK(reference.foot_point(centre).distance == Approx(5.0));
}

TEST_CASE("foot points on a torus", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeTorus(10.0, 3.0).Shape());
    for (const Vec3& p : random_points(reference.bounds(), 0.5, 400, 2)) {
        const Vec3 ring = 10.0 * Vec3(p.x(), p.y(), 0).normalized();
        const FootPoint foot = reference.foot_point(p);
        CHECK(foot.distance == Approx(std::abs((p - ring).norm() - 3.0)).margin(1e-9));
        CHECK((foot.normal - (p - ring).normalized()).norm() < 1e-6);
    }
}

TEST_CASE("foot points on a capped cylinder", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeCylinder(5.0, 20.0).Shape());
    for (const Vec3& p : random_points(reference.bounds(), 0.6, 600, 3)) {
        const double radius = std::hypot(p.x(), p.y());
        const double out_r = radius - 5.0, out_z = std::max(-p.z(), p.z() - 20.0);
        const double expected = out_r <= 0 && out_z <= 0
                                    ? std::min(-out_r, -out_z)
                                    : std::hypot(std::max(out_r, 0.0), std::max(out_z, 0.0));
        const FootPoint foot = reference.foot_point(p);
        CAPTURE(p.transpose());
        CHECK(foot.distance == Approx(expected).margin(1e-9));
        if (expected > 1e-6)
            CHECK((foot.normal.dot(p - foot.point) > 0) == (out_r > 0 || out_z > 0));
    }
}

TEST_CASE("foot points on a box: faces, edges, corners, inside", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape());
    const Vec3 half(5, 10, 15);
    for (const Vec3& p : random_points(reference.bounds(), 1.0, 600, 4)) {
        const Vec3 out = (p - half).cwiseAbs() - half;
        const bool inside = out.maxCoeff() < 0;
        const double expected = inside ? -out.maxCoeff() : out.cwiseMax(0.0).norm();
        const FootPoint foot = reference.foot_point(p);
        CAPTURE(p.transpose());
        CHECK(foot.distance == Approx(expected).margin(1e-10));
        CHECK((foot.normal.dot(p - foot.point) < 0) == inside);
    }
    CHECK(reference.foot_point(Vec3(-1, -1, -1)).point.norm() < 1e-9);
    CHECK(reference.bounds().max.isApprox(Vec3(10, 20, 30), 1e-9));
}

TEST_CASE("however far a query is, it has a foot point", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape());
    for (const double far : {1e6, 1e12, 1e18, 1e24, 1e30, 1e200}) {
        const FootPoint foot = reference.foot_point({far, 10.0, 15.0});
        CHECK(foot.face >= 0);
        CHECK(foot.point.x() == Approx(10.0));
        CHECK(foot.distance == Approx(far));
        const FootPoint corner = reference.foot_point({-far, -far, -far});
        CHECK(corner.point.norm() < 1e-3);
        CHECK(corner.distance == Approx(std::sqrt(3.0) * far));
    }
}

TEST_CASE("foot points agree with the kernel's extrema on trimmed faces", "[occ][oracle]") {
    SECTION("cylinder minus oblique box") { check_against_kernel(test::cut_cylinder(), 160, 10); }
    SECTION("plate with hole") { check_against_kernel(test::plate_with_hole(), 160, 20); }
    SECTION("lofted wing") { check_against_kernel(test::wing(), 60, 30); }
    SECTION("wing cut by an oblique box") {
        check_against_kernel(
            BRepAlgoAPI_Cut(test::wing(),
                            test::rotated_box(200, 60, 100, gp_Pnt(10, -30, 220), 0.4))
                .Shape(),
            40, 40);
    }
    SECTION("cone, apex included") {
        check_against_kernel(BRepPrimAPI_MakeCone(5.0, 0.0, 12.0).Shape(), 160, 50);
    }
    SECTION("patch with two degenerate sides") { check_against_kernel(test::horn(), 100, 60); }
    SECTION("filleted box") {
        const TopoDS_Shape box = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape();
        BRepFilletAPI_MakeFillet rounded(box);
        for (TopExp_Explorer it(box, TopAbs_EDGE); it.More(); it.Next())
            rounded.Add(2.0, TopoDS::Edge(it.Current()));
        check_against_kernel(rounded.Shape(), 160, 70);
    }
    SECTION("moved shape") {
        gp_Trsf move;
        move.SetRotation(gp_Ax1(gp_Pnt(3, 2, 1), gp_Dir(1, 1, 0)), 1.0);
        check_against_kernel(test::cut_cylinder().Moved(TopLoc_Location(move)), 60, 80);
    }
    SECTION("faces turned inside out") {
        check_against_kernel(test::plate_with_hole().Reversed(), 60, 90);
    }
}

TEST_CASE("the nearest point of a ridge inside a face is on the ridge", "[occ][oracle]") {
    const CadReference reference = reference_of(test::kinked_strip());
    const FootPoint above = reference.foot_point(Vec3(0.2, 30, 8));
    CHECK((above.point - Vec3(0, 30, 5)).norm() < 1e-7);
    const Vec3 slope = Vec3(10, 0, -5).normalized();
    const Vec3 on_right = Vec3(0, 31, 5) + 4.0 * slope;
    const FootPoint right = reference.foot_point(on_right + 2.0 * Vec3(5, 0, 10).normalized());
    CHECK((right.point - on_right).norm() < 1e-9);
}

TEST_CASE("a bend much shorter than the triangles hides no nearer point", "[occ][oracle]") {
    const Handle(Geom_BSplineSurface) surface = test::bent_strip(0.25);
    const CadReference reference = reference_of(BRepBuilderAPI_MakeFace(surface, 1e-7).Face());
    for (int i = 0; i < 60; ++i) {
        // In the hollow of the bend, where both sides and the bend itself are about equally near.
        const Vec3 query(0.02 * (i - 30), 50.3, 2.0 + 0.5 * i);
        double expected = 1e30;
        for (int k = 0; k <= 4000; ++k) {
            // The strip does not change along y.
            const double u = k <= 2000 ? 0.49 + 1e-5 * k : (k - 2000) / 2000.0;
            const gp_Pnt p = surface->Value(u, 0.5);
            expected = std::min(expected, std::hypot(p.X() - query.x(), p.Z() - query.z()));
        }
        CAPTURE(query.transpose());
        CHECK(reference.foot_point(query).distance <= expected + 1e-9);
    }
}

TEST_CASE("normals point outward whatever the faces' orientation", "[occ]") {
    const CadReference reference = reference_of(test::wing());
    const double size = reference.bounds().diagonal();
    for (const auto& sample : reference.sample(200)) {
        if (sample.normal.isZero(0.0)) continue;
        const FootPoint out = reference.foot_point(sample.point + 1e-3 * size * sample.normal);
        if (out.distance < 0.99e-3 * size) continue;
        CHECK(out.normal.dot(sample.normal) > 0.5);
    }
    CHECK(reference.foot_point(Vec3(50, 40, 100)).normal.y() > 0.5);
    CHECK(reference.foot_point(Vec3(50, -40, 100)).normal.y() < -0.5);
}

TEST_CASE("the asked-for side of a thin plate wins over the nearer one", "[occ][oracle]") {
    const CadReference reference = reference_of(BRepPrimAPI_MakeBox(100.0, 100.0, 0.5).Shape());
    const Vec3 up(0, 0, 1);
    const FootPoint plain = reference.foot_point(Vec3(50, 50, 0.1));
    CHECK(plain.point.z() == Approx(0.0).margin(1e-9));
    const FootPoint top = reference.foot_point(Vec3(50, 50, 0.1), up);
    CHECK((top.point - Vec3(50, 50, 0.5)).norm() < 1e-9);
    CHECK(top.normal.isApprox(up, 1e-9));
    CHECK(top.distance == Approx(0.4));
    CHECK(reference.foot_point(Vec3(50, 50, 0.4), -up).point.z() == Approx(0.0).margin(1e-9));
    // Beyond the rim the sharp edge's upper face counts as facing up.
    const FootPoint rim = reference.foot_point(Vec3(50, -1, 0.45), up);
    CHECK((rim.point - Vec3(50, 0, 0.5)).norm() < 1e-9);
    CHECK(rim.normal.z() == Approx(1.0));
    // A thick box has nothing on that side within reach: the plain answer stands.
    const CadReference thick = reference_of(BRepPrimAPI_MakeBox(100.0, 100.0, 50.0).Shape());
    const FootPoint far = thick.foot_point(Vec3(50, 50, 1.0), up);
    CHECK(far.point.z() == Approx(0.0).margin(1e-9));
}

TEST_CASE("the asked-for side of a thin wedge", "[occ][oracle]") {
    const CadReference reference = reference_of(test::wedge(100.0, 2.0));
    const Vec3 up = Vec3(2, 100, 0).normalized(), down = Vec3(2, -100, 0).normalized();
    const Vec3 on_top = Vec3(90, 0.2, 25);
    const FootPoint top = reference.foot_point(Vec3(90, -0.15, 25), up);
    CHECK(top.normal.isApprox(up, 1e-9));
    CHECK((top.point - on_top).norm() < 0.1);
    const FootPoint bottom = reference.foot_point(Vec3(90, 0.15, 25), down);
    CHECK(bottom.normal.isApprox(down, 1e-9));
    const FootPoint tip = reference.foot_point(Vec3(103, -0.3, 25), up);
    CHECK((tip.point - Vec3(100, 0, 25)).norm() < 1e-9);
    CHECK(tip.normal.isApprox(up, 1e-9));
}

TEST_CASE("samples lie on the model, cover every face, and never change", "[occ]") {
    const TopoDS_Shape shape = test::cut_cylinder();
    const CadReference reference = reference_of(shape);
    const auto samples = reference.sample(500);
    const auto faces = occ::faces_of(test::model_of(shape));
    CHECK(samples.size() > 500);
    CHECK(samples.size() < 1500);
    std::vector<int> count(faces.size(), 0);
    for (const auto& sample : samples) {
        REQUIRE(sample.face >= 0);
        ++count[std::size_t(sample.face)];
        CHECK(test::kernel_distance(faces[std::size_t(sample.face)], sample.point) < 3e-7);
        CHECK(sample.normal.norm() == Approx(1.0));
    }
    for (const int n : count) CHECK(n >= 8);
    const auto again = reference_of(shape).sample(500);
    REQUIRE(again.size() == samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) CHECK(again[i].point == samples[i].point);
}

TEST_CASE("parameters of answers lead back to their points", "[occ][oracle]") {
    const TopoDS_Shape shape = test::wing();
    const CadReference reference = reference_of(shape);
    const auto faces = occ::faces_of(test::model_of(shape));
    for (const Vec3& p : near_points(reference, 20.0, 300, 8)) {
        const FootPoint foot = reference.foot_point(p);
        REQUIRE(foot.face >= 0);
        const Handle(Geom_Surface) surface = BRep_Tool::Surface(faces[std::size_t(foot.face)]);
        const gp_Pnt at = surface->Value(foot.uv[0], foot.uv[1]);
        // Edges lie on their faces to the kernel's 1e-7 only.
        CHECK((Vec3(at.X(), at.Y(), at.Z()) - foot.point).norm() < 1e-6);
    }
}

TEST_CASE("principal curvatures of round surfaces", "[occ][oracle]") {
    const CadReference sphere = reference_of(BRepPrimAPI_MakeSphere(5.0).Shape());
    const auto round = sphere.curvature(sphere.foot_point(Vec3(3, 4, 2)));
    REQUIRE(round.has_value());
    CHECK(round->value[0] == Approx(-0.2));
    CHECK(round->value[1] == Approx(-0.2));

    for (const bool as_bspline : {false, true}) {
        TopoDS_Shape shape = BRepPrimAPI_MakeTorus(10.0, 3.0).Shape();
        if (as_bspline) shape = BRepBuilderAPI_NurbsConvert(shape).Shape();
        const CadReference torus = reference_of(shape);
        for (const double angle : {0.1, 1.0, 2.0, 3.0}) {
            // Along the meridian -1/r, along the parallel -cos(angle) / (R + r cos(angle)).
            const double c = std::cos(angle), s = std::sin(angle), turn = 0.7;
            const Vec3 out(std::cos(turn), std::sin(turn), 0), up(0, 0, 1);
            const FootPoint foot = torus.foot_point(10.0 * out + 4.0 * (c * out + s * up));
            const auto found = torus.curvature(foot);
            REQUIRE(found.has_value());
            CHECK(found->value[0] == Approx(-1.0 / 3.0));
            CHECK(found->value[1] == Approx(-c / (10.0 + 3.0 * c)));
            CHECK(std::abs(found->direction[0].dot(c * up - s * out)) == Approx(1.0));
            CHECK(std::abs(found->direction[1].dot(up.cross(out))) == Approx(1.0));
        }
    }
}

TEST_CASE("preparing a reference leaves the model's shape as it was", "[occ]") {
    const TopoDS_Shape shape = test::cut_cylinder();
    BRepTools::Clean(shape);
    const CadReference reference = reference_of(shape);
    for (const TopoDS_Face& face : occ::faces_of(test::model_of(shape))) {
        TopLoc_Location location;
        CHECK(BRep_Tool::Triangulation(face, location).IsNull());
    }
}

TEST_CASE("models and queries that make no sense are refused", "[occ]") {
    TopoDS_Compound empty;
    const BRep_Builder builder;
    builder.MakeCompound(empty);
    CHECK_THROWS_AS(reference_of(empty), base::InputError);
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape();
    occ::ReferenceOptions options;
    options.deflection_rel = 0.0;
    CHECK_THROWS_AS(reference_of(box, options), base::InvalidArgument);
    const CadReference reference = reference_of(box);
    CHECK_THROWS_AS(reference.foot_point(Vec3(0, 0, std::nan(""))), base::InvalidArgument);
    CHECK_THROWS_AS(reference.sample(0), base::InvalidArgument);
}
