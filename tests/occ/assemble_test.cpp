#include "occ/shapes.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

/// All edges of the cube infinitely sharp: the limit surface is the cube itself.
mesh::Cage sharp_cube(double edge) {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] < face[(i + 1) % 4]) {
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
            }
        }
    }
    return test::cube(edge, tags);
}

patch::PatchSet patches_of(const mesh::Cage& cage) {
    return patch::extract(cage, {.covering = patch::Covering::Faces}).patches;
}

patch::PatchSet joined(patch::PatchSet two, const patch::PatchSet& other) {
    const auto vertices = int(two.vertices.rows());
    const auto edges = int(two.edges.size());
    geom::Points all(two.vertices.rows() + other.vertices.rows(), 3);
    all << two.vertices, other.vertices;
    two.vertices = all;
    for (patch::PatchEdge e : other.edges) {
        e.start += vertices;
        e.end += vertices;
        two.edges.push_back(e);
    }
    for (patch::Patch p : other.patches) {
        for (auto& side : p.sides) side[0].edge += edges;
        two.patches.push_back(p);
    }
    return two;
}

}  // namespace

TEST_CASE("a sharp cube becomes a valid solid of exact volume and area", "[occ][oracle]") {
    const occ::Inspection i = occ::inspect(occ::assemble(patches_of(sharp_cube(2.0))));
    CHECK(i.solids == 1);
    CHECK(i.faces == 6);
    CHECK(i.edges == 12);
    CHECK(i.vertices == 8);
    CHECK(i.closed);
    CHECK(i.valid);
    CHECK(i.all_bicubic);
    CHECK(i.volume_mm3 == Approx(8.0).epsilon(1e-12));
    CHECK(i.area_mm2 == Approx(24.0).epsilon(1e-12));
    CHECK(i.max_tolerance_mm <= 1e-7);
    CHECK((i.bounds.max - geom::Vec3(1, 1, 1)).norm() < 1e-9);
}

TEST_CASE("inside-out patches still make a solid of positive volume", "[occ]") {
    mesh::Cage cage = sharp_cube(2.0);
    cage.points.col(0) *= -1.0;  // mirrored: all faces look inward now
    const occ::CadModel model = occ::assemble(patches_of(cage));
    const occ::Inspection i = occ::inspect(model);
    CHECK(i.volume_mm3 == Approx(8.0));
    CHECK(i.valid);
    // The kernel's writers forget that a solid's shell is turned.
    for (const char* name : {"patchwright_turned.step", "patchwright_turned.igs"}) {
        const auto file = std::filesystem::temp_directory_path() / name;
        occ::write_cad(model, file);
        for (const bool as_written : {false, true}) {
            const auto read = occ::read_cad(file, {.heal = false, .as_written = as_written});
            const auto back = occ::inspect(read.model);
            CHECK(back.volume_mm3 == Approx(8.0));
            CHECK(back.valid);
        }
        std::filesystem::remove(file);
    }
}

TEST_CASE("a solid's orientation is that of its surface, not of its cage", "[occ][oracle]") {
    // Faces of a cube with these vertices contain 3835 outward and their limit surface -58.6
    // (closed polygons of the sixth refinement: -58.7).
    const std::vector<geom::Vec3> points{{30.914, 1.868, 6.136},   {-7.391, -44.388, 37.001},
                                         {7.0, -30.016, 0.472},    {-1.507, -14.321, -15.392},
                                         {3.848, 12.349, 11.245},  {-4.185, -47.203, -27.039},
                                         {-32.279, 8.446, 36.101}, {29.844, 29.71, 31.644}};
    const mesh::Cage cage = test::make_cage(points, test::cube_faces);
    const patch::PatchSet patches = patches_of(cage);
    double volume = 0.0;
    for (const patch::Patch& p : patches.patches)
        volume += geom::moments(p.surface, geom::Vec3::Zero()).volume;
    CHECK(volume == Approx(-58.6).margin(0.3));
    CHECK(occ::inspect(occ::assemble(patches)).volume_mm3 == Approx(-volume).epsilon(1e-3));
}

TEST_CASE("sizes beyond the kernel's resolution are refused", "[occ][errors]") {
    const auto box = [](double from, double size) {
        geom::Box3 result;
        result.add(geom::Vec3::Constant(from));
        result.add(geom::Vec3::Constant(from + size));
        return result;
    };
    CHECK_NOTHROW(occ::check_size(box(0.0, 0.01), "x.obj"));
    CHECK_NOTHROW(occ::check_size(box(0.99e7, 1.0), "x.obj"));
    CHECK_THROWS_WITH(occ::check_size(box(0.0, 1e-3), "x.obj"), Contains("x.obj: the model is"));
    CHECK_THROWS_WITH(occ::check_size(box(-1e12, 1.0), "x.obj"), Contains("beyond 1e+07 mm"));
    CHECK_THROWS_AS(occ::check_size({}, "x.obj"), base::InputError);
}

TEST_CASE("open patch sets become shells, several parts a compound", "[occ]") {
    const occ::Inspection open = occ::inspect(occ::assemble(patches_of(test::grid(3, 2))));
    CHECK(open.solids == 0);
    CHECK(open.shells_open == 1);
    CHECK(open.free_edges == 10);
    CHECK(open.valid);

    const occ::Inspection both = occ::inspect(
        occ::assemble(joined(patches_of(sharp_cube(2.0)), patches_of(test::torus(6, 6, 9, 2)))));
    CHECK(both.solids == 2);
    CHECK(both.closed);
    CHECK(both.valid);
}

TEST_CASE("parts inside others are voids, parts that cross are solids", "[occ][oracle]") {
    const auto beside = [](double edge, double shift) {
        mesh::Cage cage = sharp_cube(edge);
        cage.points.array() += shift;
        return patches_of(cage);
    };
    const occ::Inspection hollow =
        occ::inspect(occ::assemble(joined(beside(4.0, 0.0), beside(2.0, 0.0))));
    CHECK(hollow.solids == 1);
    CHECK(hollow.shells_closed == 2);
    CHECK(hollow.valid);
    CHECK(hollow.volume_mm3 == Approx(64.0 - 8.0));
    // One corner of each inside the other, in either order.
    for (const bool first : {true, false}) {
        const occ::Inspection crossing = occ::inspect(
            occ::assemble(joined(beside(2.0, first ? 0.0 : 1.0), beside(2.0, first ? 1.0 : 0.0))));
        CHECK(crossing.solids == 2);
        CHECK(crossing.valid);
        CHECK(crossing.volume_mm3 == Approx(16.0));
    }
    // A bar that sticks out of a cube, whose first vertices are inside.
    mesh::Cage bar = sharp_cube(1.0);
    bar.points.col(2) = (3.0 * bar.points.col(2).array() + 1.5).matrix();
    const occ::Inspection sticking =
        occ::inspect(occ::assemble(joined(beside(4.0, 0.0), patches_of(bar))));
    CHECK(sticking.solids == 2);
    CHECK(sticking.valid);
}

TEST_CASE("a side may consist of several edges", "[occ]") {
    // Two squares above one wide rectangle: the rectangle's upper side has a vertex in its middle.
    const auto line = [](const geom::Vec3& a, const geom::Vec3& b, double length) {
        geom::BsplineCurve curve{{0, 0, 0, 0, length, length, length, length}, geom::Points(4, 3)};
        for (int i = 0; i < 4; ++i) curve.points.row(i) = (a + (b - a) * i / 3.0).transpose();
        return curve;
    };
    const auto rectangle = [](double x0, double x1, double y0, double y1) {
        const double w = x1 - x0;
        geom::BsplineSurface s{
            {0, 0, 0, 0, w, w, w, w}, {0, 0, 0, 0, 1, 1, 1, 1}, geom::Points(16, 3)};
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j)
                s.point(i, j) << x0 + w * i / 3.0, y0 + (y1 - y0) * j / 3.0, 0.0;
        }
        return s;
    };
    patch::PatchSet set;
    set.vertices.resize(8, 3);
    set.vertices << 0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0, 0, 1, 0, 2, 2, 0, 1, 2, 0, 0, 2, 0;
    const auto edge = [&](int a, int b, double length) {
        set.edges.push_back(
            {a, b, line(set.vertices.row(a).transpose(), set.vertices.row(b).transpose(), length),
             false});
        return int(set.edges.size()) - 1;
    };
    const int bottom = edge(0, 1, 2), right = edge(1, 2, 1), top_right = edge(2, 3, 1);
    const int top_left = edge(3, 4, 1), left = edge(4, 0, 1), r2 = edge(2, 5, 1),
              t2 = edge(5, 6, 1);
    const int middle = edge(6, 3, 1), t3 = edge(6, 7, 1), l3 = edge(7, 4, 1);
    set.patches.push_back({rectangle(0, 2, 0, 1),
                           {{{{bottom, false}},
                             {{right, false}},
                             {{top_right, false}, {top_left, false}},
                             {{left, false}}}},
                           "wide"});
    set.patches.push_back({rectangle(1, 2, 1, 2),
                           {{{{top_right, true}}, {{r2, false}}, {{t2, false}}, {{middle, false}}}},
                           "right"});
    set.patches.push_back({rectangle(0, 1, 1, 2),
                           {{{{top_left, true}}, {{middle, true}}, {{t3, false}}, {{l3, false}}}},
                           "left"});
    const occ::CadModel model = occ::assemble(set);
    const occ::Inspection i = occ::inspect(model);
    CHECK(i.valid);
    CHECK(i.free_edges == 7);
    CHECK(i.edges == 10);
    CHECK(i.area_mm2 == Approx(4.0));
    CHECK(i.all_bicubic);
    CHECK(occ::measure_continuity(model, geom::Points(0, 3)).max_gap_mm < 1e-12);

    std::swap(set.patches[0].sides[2][0], set.patches[0].sides[2][1]);
    set.patches[0].sides[2].pop_back();
    CHECK_THROWS_WITH(occ::assemble(set), Contains("side 2"));
}

TEST_CASE("what is no manifold is refused with edge and patches", "[occ][errors]") {
    const patch::PatchSet good = patches_of(sharp_cube(2.0));
    patch::PatchSet bad = good;
    bad.patches.push_back(bad.patches[0]);
    CHECK_THROWS_WITH(occ::assemble(bad), Contains("more than two patches (0"));
    bad = good;
    bad.patches[0].sides[0][0].reversed = !bad.patches[0].sides[0][0].reversed;
    CHECK_THROWS_WITH(occ::assemble(bad), Contains("runs the same way"));
    bad = good;
    bad.patches[0].sides[0][0].edge = 99;
    CHECK_THROWS_WITH(occ::assemble(bad), Contains("edge 99"));
    CHECK_THROWS_AS(occ::assemble(patch::PatchSet{}), base::InvalidArgument);
}

TEST_CASE("random closed and open cages become valid shapes without gaps", "[occ]") {
    for (unsigned seed = 0; seed < 16; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 1, .crease_share = 0.1 * (seed % 4)});
        const auto extraction = patch::extract(cage);
        const occ::CadModel model = occ::assemble(extraction.patches);
        const occ::Inspection i = occ::inspect(model);
        CHECK(i.valid);
        CHECK(i.closed == cage.topology->is_closed());
        CHECK(i.nonmanifold_edges == 0);
        const auto creases = patch::crease_midpoints(extraction.patches);
        const patch::Continuity c = occ::measure_continuity(model, creases);
        CHECK(c.max_gap_mm < 1e-9 * i.bounds.diagonal());
        CHECK(c.crease_edges == creases.rows());
    }
}
