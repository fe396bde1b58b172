#include "occ/foot/foot_point_engine.h"

#include "occ/near_points.h"
#include "occ/odd_shapes.h"
#include "occ/shapes.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/patch/extract.h>

#include <ShapeFix_ShapeTolerance.hxx>
#include <catch2/catch.hpp>

using namespace patchwright;
using geom::FootPoint;
using geom::Vec3;
using occ::CadReference;
using test::near_points;

namespace {

CadReference reference_of(const TopoDS_Shape& shape) { return CadReference(test::model_of(shape)); }

}  // namespace

TEST_CASE("queries from several threads give the answers of one", "[occ]") {
    const CadReference reference = reference_of(test::wing());
    const auto points = near_points(reference, 10.0, 2000, 5);
    std::vector<FootPoint> parallel(points.size());
    base::parallel_for(points.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            parallel[i] = reference.foot_point(points[i], Vec3(0, 1, 0));
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
        const FootPoint one = reference.foot_point(points[i], Vec3(0, 1, 0));
        CHECK(one.point == parallel[i].point);
        CHECK(one.face == parallel[i].face);
    }
}

TEST_CASE("triangles stay near the faces beside edges of large tolerance", "[occ][oracle]") {
    const auto patches = patch::extract(test::cube(100.0)).patches;
    const CadReference sound = reference_of(occ::assemble(patches).impl().shape);
    const TopoDS_Shape loose = occ::assemble(patches).impl().shape;
    for (const TopAbs_ShapeEnum kind : {TopAbs_EDGE, TopAbs_VERTEX})
        ShapeFix_ShapeTolerance().SetTolerance(loose, 20.0, kind);
    const CadReference reference = reference_of(loose);
    const auto farthest = [](const CadReference& of) {
        double error = 0.0;
        for (const auto& t : of.search_model().mesh.triangles) error = std::max(error, t.error);
        return error;
    };
    CHECK(farthest(reference) < 10.0 * farthest(sound));
    for (const Vec3& q : near_points(sound, 10.0, 500, 7))
        CHECK(reference.foot_point(q).distance == Approx(sound.foot_point(q).distance));
}

TEST_CASE("a batch and a warm start give the answers of single queries, bit for bit", "[occ]") {
    const auto same = [](const FootPoint& a, const FootPoint& b) {
        return a.point == b.point && a.normal == b.normal && a.distance == b.distance &&
               a.face == b.face && a.uv == b.uv;
    };
    const auto check = [&](const TopoDS_Shape& shape) {
        const CadReference reference = reference_of(shape);
        const auto near = near_points(reference, 10.0, 1000, 6);
        geom::Points queries(Eigen::Index(near.size()), 3), sides = geom::Points::Zero(1000, 3);
        for (Eigen::Index i = 0; i < queries.rows(); ++i) {
            queries.row(i) = near[std::size_t(i)].transpose();
            if (i % 3 == 0) sides(i, 1) = 1.0;
        }
        const auto plain = reference.foot_points(queries);
        const auto facing = reference.foot_points(queries, sides);
        REQUIRE(plain.size() == near.size());
        int differ = 0;
        for (std::size_t i = 0; i < near.size(); ++i) {
            const FootPoint one = reference.foot_point(near[i]);
            const FootPoint up = i % 3 == 0 ? reference.foot_point(near[i], Vec3(0, 1, 0)) : one;
            const FootPoint& last = plain[(i * 7) % near.size()];
            differ += same(plain[i], one) && same(facing[i], up) &&
                              same(reference.foot_point_from(last, near[i]), one)
                          ? 0
                          : 1;
        }
        CHECK(differ == 0);
    };
    SECTION("wing") { check(test::wing()); }
    SECTION("trimmed faces") { check(test::cut_cylinder()); }
    SECTION("degenerate sides") { check(test::horn()); }

    const CadReference reference = reference_of(test::plate_with_hole());
    geom::Points queries = geom::Points::Zero(10, 3);
    CHECK_THROWS_AS(reference.foot_points(queries, geom::Points::Zero(3, 3)),
                    base::InvalidArgument);
    queries(5, 1) = std::nan("");
    CHECK_THROWS_AS(reference.foot_points(queries), base::InvalidArgument);
}

// What lets a search leave edges and neighbouring triangles out must hold.
TEST_CASE("no edge is nearer to a triangle than its clearance, nor runs through its part of a face",
          "[occ][oracle]") {
    int most_known = 0;
    for (const TopoDS_Shape& shape :
         {test::wing(), test::plate_with_hole(), test::cut_cylinder()}) {
        const CadReference reference = reference_of(shape);
        const occ::SearchModel& model = reference.search_model();
        std::vector<Vec3> on_edges;
        for (const occ::ModelEdge& edge : model.network.edges)
            for (int i = 0; i <= 200; ++i)
                on_edges.push_back(edge.at(edge.first + (edge.last - edge.first) * i / 200));
        int known = 0, near = 0, outside = 0;
        for (std::size_t slot = 0; slot < model.mesh.around.size(); slot += 3) {
            const double clearance = model.mesh.around[slot].clearance;
            if (!(clearance > 0.0)) continue;
            ++known;
            const auto& t = model.mesh.triangles[std::size_t(model.mesh.tree.numbers()[slot])];
            for (const Vec3& p : on_edges) {
                const Vec3 w = geom::nearest_weights(p, t.corner);
                const Vec3 q = w[0] * t.corner[0] + w[1] * t.corner[1] + w[2] * t.corner[2];
                near += (p - q).norm() < clearance * (1.0 - 1e-6) ? 1 : 0;
            }
            for (const auto& uv : t.uv)
                outside += model.surfaces[std::size_t(t.face)].contains(uv) ? 0 : 1;
        }
        most_known = std::max(most_known, known);
        CHECK(near == 0);
        CHECK(outside == 0);
    }
    CHECK(most_known > 20);  // few triangles of flat faces touch no edge
}
