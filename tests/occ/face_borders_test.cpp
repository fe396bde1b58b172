#include "occ/near_points.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>

#include <BRepPrimAPI_MakeSphere.hxx>
#include <catch2/catch.hpp>

#include <Eigen/Geometry>

using namespace patchwright;
using geom::FaceBorder;
using geom::FootPoint;
using geom::Vec3;

namespace {

/// A box with a round hole through it, which has closed edges and a seam.
TopoDS_Shape box_with_hole() {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(100.0, 60.0, 30.0).Shape();
    const TopoDS_Shape hole =
        BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(50, 30, -10), gp_Dir(0, 0, 1)), 12.0, 60.0).Shape();
    return BRepAlgoAPI_Cut(box, hole).Shape();
}

std::vector<TopoDS_Shape> faces_of(const TopoDS_Shape& shape) {
    std::vector<TopoDS_Shape> result;
    for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
        result.push_back(it.Current());
    return result;
}

std::vector<char> only(int face, std::size_t count) {
    std::vector<char> flags(count, 0);
    flags[std::size_t(face)] = 1;
    return flags;
}

}  // namespace

TEST_CASE("nearest points on one face are the kernel's on that face", "[occ][oracle]") {
    const TopoDS_Shape shape = box_with_hole();
    const occ::CadReference reference(test::model_of(shape));
    const std::vector<TopoDS_Shape> faces = faces_of(shape);
    REQUIRE(faces.size() == 7);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (const Vec3& p : test::near_points(reference, 20.0, 60, unsigned(f))) {
            const FootPoint foot = reference.foot_point_on(only(int(f), faces.size()), p);
            CAPTURE(f, p.transpose(), foot.point.transpose());
            CHECK(foot.face == int(f));
            CHECK(foot.distance == Approx(test::kernel_distance(faces[f], p)).margin(1e-6));
            CHECK((foot.point - p).norm() == Approx(foot.distance).margin(1e-9));
            CHECK(test::kernel_distance(faces[f], foot.point) < 1e-6);
        }
    }
    CHECK_THROWS_AS(reference.foot_point_on({1}, Vec3::Zero()), base::InvalidArgument);
}

TEST_CASE("of some faces those that face alike are preferred", "[occ][oracle]") {
    // From within the box, 5 mm below its top: the bottom where the side asks for it.
    const occ::CadReference reference(
        test::model_of(BRepPrimAPI_MakeBox(100.0, 60.0, 30.0).Shape()), {.side_reach_rel = 0.5});
    std::vector<char> top_and_bottom;
    for (int f = 0; f < 6; ++f)
        top_and_bottom.push_back(
            std::abs(reference.point_on_face(f, Eigen::Vector2d(1.0, 1.0)).normal.z()) > 0.5);
    const Vec3 query(2.0, 30.0, 25.0);
    CHECK(reference.foot_point(query).point.isApprox(Vec3(0, 30, 25), 1e-9));
    CHECK(reference.foot_point_on(top_and_bottom, query).point.isApprox(Vec3(2, 30, 30), 1e-9));
    CHECK(reference.foot_point_on(top_and_bottom, query, -Vec3::UnitZ())
              .point.isApprox(Vec3(2, 30, 0), 1e-9));
}

TEST_CASE("borders of faces know what is left and right of their curve", "[occ][oracle]") {
    const TopoDS_Shape shape = box_with_hole();
    const occ::CadReference reference(test::model_of(shape));
    const std::vector<FaceBorder> borders = reference.face_borders();
    CHECK(borders.size() == 15);  // 12 edges of the box, 2 of the hole and its seam
    constexpr double step = 1e-2;
    for (const FaceBorder& b : borders) {
        REQUIRE(b.curve >= 0);
        const double middle = 0.4 * reference.features().curves[std::size_t(b.curve)].length;
        const geom::FeaturePoint at = reference.point_on_curve(b.curve, middle);
        CAPTURE(b.curve, b.left, b.right, at.point.transpose());
        for (const bool left : {true, false}) {
            const std::vector<char> face = only(left ? b.left : b.right, 7);
            const Vec3 normal = reference.foot_point_on(face, at.point).normal;
            const Vec3 into = (left ? 1.0 : -1.0) * step * normal.cross(at.tangent);
            // On the face, but for how much the hole bends within the step; the seam has the same
            // face on both sides.
            CHECK(reference.foot_point_on(face, at.point + into).distance < 0.01 * step);
            if (b.left != b.right)
                CHECK(reference.foot_point_on(face, at.point - into).distance > 0.99 * step);
        }
    }
}

TEST_CASE("a face without edges is listed, too", "[occ]") {
    const occ::CadReference sphere(test::model_of(BRepPrimAPI_MakeSphere(5.0).Shape()));
    const auto borders = sphere.face_borders();
    REQUIRE_FALSE(borders.empty());
    for (const FaceBorder& b : borders) CHECK(std::max(b.left, b.right) == 0);
}
