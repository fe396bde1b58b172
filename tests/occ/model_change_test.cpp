#include "occ/near_points.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/model_change.h>
#include <patchwright/geom/mesh_reference.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <catch2/catch.hpp>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

using namespace patchwright;
using geom::Vec3;
using occ::CadReference;

namespace {

const Vec3 plank_size(40.0, 300.0, 10.0);

/// A beam along y whose far end is lifted by this, and places between with the square of y.
class Plank {
  public:
    explicit Plank(double lift) : lift_(lift) {}

    /// @param turned  the parameters of the far end are others
    [[nodiscard]] TopoDS_Shape shape(bool turned = false) const {
        std::vector<TopoDS_Face> faces;
        for (const double y : {0.0, 1.0}) {
            const Handle(Geom_BezierSurface) end =
                sheet(2, 2, [&](double u, double v) { return Vec3(u, y, v); });
            if (turned && y == 1.0) end->ExchangeUV();
            if (turned && y == 1.0) end->UReverse();
            faces.push_back(BRepBuilderAPI_MakeFace(end, 1e-6).Face());
        }
        for (const double side : {0.0, 1.0}) {
            faces.push_back(face([&](double u, double v) { return Vec3(side, v, u); }));
            faces.push_back(face([&](double u, double v) { return Vec3(u, v, side); }));
        }
        BRepBuilderAPI_Sewing sewing(1e-5);
        for (const TopoDS_Face& f : faces) sewing.Add(f);
        sewing.Perform();
        return sewing.SewedShape();
    }

    [[nodiscard]] Vec3 displacement(const Vec3& straight) const {
        const double along = straight.y() / plank_size.y();
        return {0.0, 0.0, lift_ * along * along};
    }

  private:
    using Place = std::function<Vec3(double, double)>;

    /// Poles of z(y) = lift y^2 in Bernstein polynomials of degree 2 are 0, 0, lift.
    [[nodiscard]] Handle(Geom_BezierSurface)
        sheet(int u_poles, int v_poles, const Place& place) const {
        TColgp_Array2OfPnt poles(1, u_poles, 1, v_poles);
        for (int i = 0; i < u_poles; ++i)
            for (int j = 0; j < v_poles; ++j) {
                const Vec3 share = place(double(i) / (u_poles - 1), double(j) / (v_poles - 1));
                const Vec3 p = share.cwiseProduct(plank_size);
                poles(i + 1, j + 1) =
                    gp_Pnt(p.x(), p.y(), p.z() + (share.y() == 1.0 ? lift_ : 0.0));
            }
        return new Geom_BezierSurface(poles);
    }
    [[nodiscard]] TopoDS_Face face(const Place& place) const {
        return BRepBuilderAPI_MakeFace(sheet(2, 3, place), 1e-6).Face();
    }

    double lift_;
};

/// The faces in reverse order.
TopoDS_Shape reversed(const TopoDS_Shape& shape) {
    std::vector<TopoDS_Shape> faces;
    for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
        faces.push_back(it.Current());
    TopoDS_Compound result;
    const BRep_Builder builder;
    builder.MakeCompound(result);
    std::for_each(faces.rbegin(), faces.rend(),
                  [&](const TopoDS_Shape& face) { builder.Add(result, face); });
    return result;
}

CadReference reference_of(const TopoDS_Shape& shape, std::vector<std::string> names = {}) {
    auto impl = std::make_shared<occ::CadModel::Impl>();
    impl->shape = shape;
    impl->face_names = std::move(names);
    return CadReference(occ::CadModel(impl));
}

/// Largest difference of the displacements of points near the earlier model from the expected ones.
double error(const CadReference& earlier, const CadReference& later,
             const std::function<Vec3(const Vec3&)>& expected) {
    const fit::ModelChange change({earlier, "old.step"}, {later, "new.step"});
    double largest = 0.0;
    for (const Vec3& p : test::near_points(earlier, 0.0, 300, 7))
        largest = std::max(largest, (change.displacement_at(p) - expected(p)).norm());
    return largest;
}

}  // namespace

TEST_CASE("a known bend of a model is known at every point", "[fit][occ][oracle]") {
    const Plank straight(0.0), bent(80.0);
    const auto expected = [&](const Vec3& p) { return bent.displacement(p); };
    const CadReference earlier = reference_of(straight.shape());
    CHECK(error(earlier, reference_of(bent.shape()), expected) < 1e-6);
    // The far end has other parameters: it moves with its border.
    CHECK(error(earlier, reference_of(bent.shape(true)), expected) < 1e-6);
}

TEST_CASE("boxes and cylinders of other sizes are affine maps", "[fit][occ][oracle]") {
    const CadReference box = reference_of(BRepPrimAPI_MakeBox(30, 20, 10).Shape());
    const CadReference other = reference_of(BRepPrimAPI_MakeBox(45, 10, 25).Shape());
    CHECK(error(box, other,
                [](const Vec3& p) { return Vec3(0.5 * p.x(), -0.5 * p.y(), 1.5 * p.z()); }) < 1e-9);
    // Ranges of round faces are those of their triangles' nodes.
    const CadReference cylinder = reference_of(BRepPrimAPI_MakeCylinder(10, 50).Shape());
    const CadReference wider = reference_of(BRepPrimAPI_MakeCylinder(15, 40).Shape());
    CHECK(error(cylinder, wider,
                [](const Vec3& p) { return Vec3(0.5 * p.x(), 0.5 * p.y(), -0.2 * p.z()); }) < 1e-2);
}

TEST_CASE("faces belong together by their names where these tell them apart", "[fit][occ]") {
    const Plank straight(0.0), bent(80.0);
    const std::vector<std::string> names{"root", "tip", "a", "b", "c", "d"};
    const CadReference earlier = reference_of(straight.shape(), names);
    const CadReference later = reference_of(reversed(bent.shape()), {names.rbegin(), names.rend()});
    CHECK(error(earlier, later, [&](const Vec3& p) { return bent.displacement(p); }) < 1e-6);
    const CadReference unnamed = reference_of(straight.shape());
    const CadReference unnamed_later = reference_of(reversed(bent.shape()));
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH(fit::ModelChange({unnamed, "old.step"}, {unnamed_later, "new.step"}),
                      Contains("old.step") && Contains("other parameters"));
}

TEST_CASE("models without the same faces tell nothing of a change", "[fit][occ]") {
    using Catch::Matchers::Contains;
    const CadReference box = reference_of(BRepPrimAPI_MakeBox(30, 20, 10).Shape());
    const CadReference cylinder = reference_of(BRepPrimAPI_MakeCylinder(10, 50).Shape());
    CHECK_THROWS_WITH(fit::ModelChange({box, "old.step"}, {cylinder, "new.step"}),
                      Contains("old.step: it has 6 faces, and the new model 3"));
    geom::TriangleMesh mesh{.points = geom::Points(4, 3),
                            .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                            .part = {-1, -1, -1, -1}};
    mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    const geom::MeshReference triangles(mesh);
    CHECK_THROWS_WITH(fit::ModelChange({triangles, "old.stl"}, {box, "new.step"}),
                      Contains("old.stl: triangles"));
}
