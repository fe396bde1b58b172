// Heights and sections along straight and bent spines.
#include "cage/sections/sections.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

namespace patchwright {
namespace {

using cage::Spine;
using geom::Vec3;

/// A square tube of quads around points of the (y, z) plane, its sides along x and in that plane;
/// ends are open. Inner and outer corners of bends lie on bisecting planes.
struct Tube {
    static constexpr double width = 100.0, straight = 1000.0;

    /// Along y, then up along z.
    static std::vector<Spine::Plane> planes() {
        return {{Vec3(0, 0, 0), Vec3(0, 1, 0)},
                {Vec3(0, straight - 3.0 * width, 0), Vec3(0, 1, 0)},
                {Vec3(0, straight, 0), Vec3(0, 1, 1).normalized()},
                {Vec3(0, straight, 3.0 * width), Vec3(0, 0, 1)},
                {Vec3(0, straight, straight), Vec3(0, 0, 1)}};
    }

    static geom::SurfaceMesh mesh() {
        geom::SurfaceMesh mesh;
        const double w = 0.5 * width;
        mesh.points.resize(12, 3);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 4; ++k) {
                const double x = k == 0 || k == 3 ? -w : w, off = k < 2 ? -w : w;
                mesh.points.row(4 * i + k) = i == 0   ? Vec3(x, 0, off)
                                             : i == 1 ? Vec3(x, straight - off, off)
                                                      : Vec3(x, straight - off, straight);
            }
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 4; ++k) {
                const int a = 4 * i + k, b = 4 * i + (k + 1) % 4;
                mesh.triangles.push_back({a, b, b + 4});
                mesh.triangles.push_back({a, b + 4, a + 4});
                mesh.faces.insert(mesh.faces.end(), 2, 4 * i + k);
            }
        return mesh;
    }
};

TEST_CASE("heights along an axis are its coordinates", "[spine]") {
    const Spine spine(Vec3(0, 1, 0));
    CHECK(spine.height(Vec3(3, 7, -2)) == 7.0);
    CHECK(spine.offset(Vec3(3, 7, -2), 4.0) == 3.0);
    CHECK(spine.direction(5.0) == Vec3(0, 1, 0));
}

TEST_CASE("a fan's sections hold the points of their heights", "[spine]") {
    const Spine spine(Tube::planes(), Vec3(1, 0, 0));
    CHECK(spine.length() == Approx(2.0 * Tube::straight));
    for (const Vec3& p : {Vec3(20, 300, 10), Vec3(-5, 830, -40), Vec3(0, 960, 45),
                          Vec3(8, 1030, 120), Vec3(0, 990, 700), Vec3(1, -20, 5)}) {
        const double height = spine.height(p);
        CHECK(std::abs(spine.offset(p, height)) < 1e-9);
        CHECK(spine.offset(p + spine.direction(height), height) > 0.0);
        // The width of a step along the normal, where sections are parallel.
        if (p.y() < 700.0)
            CHECK(spine.height(p + Vec3(0, 1, 0)) == Approx(height + 1.0).margin(1e-9));
    }
    CHECK(spine.height(Vec3(0, Tube::straight, 500)) == Approx(Tube::straight + 500.0));
}

TEST_CASE("a bent tube is cut into one closed section at every height", "[spine]") {
    const geom::SurfaceMesh mesh = Tube::mesh();
    const auto bodies = cage::bodies_of(mesh);
    REQUIRE(bodies.size() == 1);
    const cage::Slicer slicer(bodies[0], Spine(Tube::planes(), Vec3(1, 0, 0)));
    CHECK(slicer.low() == Approx(0.0).margin(1e-9));
    CHECK(slicer.high() == Approx(2.0 * Tube::straight));
    for (int i = 1; i < 40; ++i) {
        const double height = slicer.high() * i / 40.0;
        const auto loops = slicer.cut(height);
        REQUIRE(loops.size() == 1);
        CHECK(loops[0].closed);
        // A square where planes are, a longer rectangle where they lie askew in the bend.
        const double askew = slicer.spine().direction(height).cwiseAbs().maxCoeff();
        CHECK(loops[0].length() == Approx(2.0 * Tube::width * (1.0 + 1.0 / askew)));
        for (const Vec3& p : loops[0].points)
            CHECK(std::abs(slicer.spine().offset(p, height)) < 1e-6);
    }
}

}  // namespace
}  // namespace patchwright
