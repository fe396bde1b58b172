#include "measure/spline_shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/self_intersection.h>

#include <catch2/catch.hpp>

#include <cmath>

using namespace patchwright;
using geom::Vec3;
using test::spline_surface;

namespace {

/// A planar cubic Bezier curve swept along z.
geom::BsplineSurface swept(const std::array<Eigen::Vector2d, 4>& curve, double length) {
    geom::BsplineSurface s{test::uniform_knots(1), test::uniform_knots(1), geom::Points(16, 3)};
    for (Eigen::Index i = 0; i < 4; ++i) {
        for (Eigen::Index j = 0; j < 4; ++j) {
            const Eigen::Vector2d& p = curve[std::size_t(i)];
            s.point(i, j) << p.x(), p.y(), length * double(j) / 3.0;
        }
    }
    return s;
}

/// A cambered wing section of 1 m chord, from the trailing edge below round the nose and back
/// above, 2 m span.
geom::BsplineSurface wing(double thickness_mm, double lift_mm, double trailing_gap_mm) {
    return spline_surface(60, 10, [=](double u, double v) {
        const double s = 2.0 * u - 1.0, side = s < 0.0 ? -1.0 : 1.0;
        const double x = s * s, half = 0.5 * thickness_mm;
        const double section = std::sqrt(x) * (1.0 - x) * 1.5;
        const double camber = 100.0 * x * (1.0 - x) + lift_mm * side * x * x * (1.0 - x);
        return Vec3(1000.0 * x, 2000.0 * v,
                    camber + side * (half * section + 0.5 * trailing_gap_mm * x));
    });
}

using Hits = std::vector<measure::SelfIntersection>;

Hits find_self_intersections(const std::vector<geom::BsplineSurface>& surfaces,
                             double resolution_mm) {
    return measure::find_self_intersections(surfaces, resolution_mm);
}

/// Of surfaces with themselves: those of the tests lie in each other's way.
Hits find_loops(const std::vector<geom::BsplineSurface>& surfaces, double resolution_mm) {
    Hits hits = find_self_intersections(surfaces, resolution_mm);
    std::erase_if(hits, [](const auto& hit) { return hit.surfaces[0] != hit.surfaces[1]; });
    return hits;
}

void check_closes(const geom::BsplineSurface& s, const measure::SelfIntersection& hit) {
    for (const Eigen::Vector2d& uv : hit.uv)
        CHECK((s.at(uv[0], uv[1]).position - hit.point).norm() < 1e-4);
    CHECK((hit.uv[0] - hit.uv[1]).norm() > 1e-3);
}

}  // namespace

TEST_CASE("a swept loop crosses itself where its curve does", "[measure][oracle]") {
    // Symmetric about x = 0.5; with inner points at 0.5 +- a it has a loop when a < -1/6, a cusp
    // at -1/6... of the left one.
    const auto curve = [](double a) {
        return std::array<Eigen::Vector2d, 4>{
            Eigen::Vector2d{0, 0}, {0.5 + a, 1.0}, {0.5 - a, 1.0}, {1, 0}};
    };
    const std::vector<geom::BsplineSurface> surfaces{swept(curve(1.5), 4.0), swept(curve(0.4), 4.0),
                                                     swept(curve(0.6), 4.0)};
    const auto hits = find_loops(surfaces, 1e-3);
    REQUIRE(hits.size() == 2);
    CHECK(hits[0].surfaces[0] == 0);
    CHECK(hits[1].surfaces[0] == 2);
    CHECK(hits[0].point.x() == Approx(0.5));
    check_closes(surfaces[0], hits[0]);
    // The loop is 0.05 long.
    CHECK(find_loops(surfaces, 0.2).size() == 1);
    CHECK_THROWS_AS(find_loops(surfaces, 0.0), base::InvalidArgument);
}

TEST_CASE("closed surfaces and poles are no self-intersections", "[measure][oracle]") {
    const auto torus = spline_surface(24, 16, [](double u, double v) {
        const double a = 2 * M_PI * u, b = 2 * M_PI * v, r = 30.0 + 10.0 * std::cos(b);
        return Vec3(r * std::cos(a), r * std::sin(a), 10.0 * std::sin(b));
    });
    const auto sphere = spline_surface(20, 10, [](double u, double v) {
        const double a = 2 * M_PI * u, b = M_PI * v;
        return Vec3(50 * std::cos(a) * std::sin(b), 50 * std::sin(a) * std::sin(b),
                    -50 * std::cos(b));
    });
    CHECK(find_loops({torus, sphere}, 0.01).empty());
    // A torus whose section is a figure of eight.
    const auto eight = spline_surface(24, 32, [](double u, double v) {
        const double a = 2 * M_PI * u, b = 2 * M_PI * v, r = 30.0 + 10.0 * std::sin(b);
        return Vec3(r * std::cos(a), r * std::sin(a), 5.0 * std::sin(2 * b));
    });
    const auto hits = find_loops({torus, eight}, 0.01);
    REQUIRE(hits.size() == 1);
    CHECK(hits[0].surfaces[0] == 1);
    check_closes(eight, hits[0]);
}

TEST_CASE("skins near each other are told from skins that cross", "[measure][oracle]") {
    const double resolution = 0.1;
    CHECK(find_loops({wing(120.0, 0.0, 0.0)}, resolution).empty());
    CHECK(find_loops({wing(0.1, 0.0, 0.0)}, resolution).empty());
    CHECK(find_loops({wing(0.1, 0.0, 0.1)}, resolution).empty());
    const auto crossing = wing(20.0, -100.0, 0.0);
    const auto hits = find_loops({crossing}, resolution);
    REQUIRE(hits.size() == 1);
    check_closes(crossing, hits[0]);
}

TEST_CASE("a sheet folded over itself", "[measure][oracle]") {
    // x goes 0 to 60, back to 40 and on to 100; the middle layer lies between the others or passes
    // through the upper one.
    const auto folded = [](double lift) {
        return spline_surface(40, 4, [=](double u, double v) {
            const double x = 100.0 * u + 45.0 * std::sin(2 * M_PI * u);
            return Vec3(x, 50.0 * v, lift * std::cos(M_PI * u) + (v - 0.5) * 4.0);
        });
    };
    CHECK(find_loops({folded(5.0)}, 0.1).empty());
    // All layers in one plane.
    const auto hits = find_loops({folded(0.0)}, 0.1);
    REQUIRE(hits.size() == 1);
    check_closes(folded(0.0), hits[0]);
}

TEST_CASE("surfaces without area end, and never count as sound", "[measure][errors]") {
    // All of a surface on a line: by saddles, whose level lines are bent; by a plane, whose level
    // lines are straight, so that no visit to a place leaves it; and as one point.
    const Vec3 line(3.0, 4.0, 12.0);
    const std::vector<geom::BsplineSurface> surfaces{
        spline_surface(6, 6,
                       [&](double u, double v) { return Vec3(line * (u + v - 2.0 * u * v)); }),
        spline_surface(6, 6, [&](double u, double v) { return Vec3(line * (u + v)); }),
        spline_surface(6, 6,
                       [&](double u, double v) { return Vec3(line + 1e-9 * Vec3(u, v, 0)); })};
    const auto hits = find_loops(surfaces, 1e-3);
    REQUIRE(hits.size() == 2);
    CHECK(hits[0].is_found);
    check_closes(surfaces[0], hits[0]);
    CHECK(hits[1].surfaces[0] == 1);
    CHECK_FALSE(hits[1].is_found);
}

TEST_CASE("a sheet folded flat on itself is found out by its largest parts", "[measure][oracle]") {
    // Its smallest parts alone would take hours.
    const std::vector<geom::BsplineSurface> surfaces{spline_surface(
        8, 8, [](double u, double v) { return Vec3(1e3 * u * (1.0 - u), 1e3 * v, 0.0); })};
    const auto hits = find_loops(surfaces, 1e-4);
    REQUIRE(hits.size() == 1);
    CHECK(hits[0].is_found);
    check_closes(surfaces[0], hits[0]);
}

TEST_CASE("slender sheets are as simple as wide ones", "[measure][oracle]") {
    // Parameter lines at angles down to 0.1 degrees; the last one crosses itself.
    std::vector<geom::BsplineSurface> surfaces;
    for (const double width : {1.0, 0.03, 0.001})
        surfaces.push_back(spline_surface(10, 10, [=](double u, double v) {
            return Vec3(u + v, width * (u - v), 0.2 * (u * u + v * v));
        }));
    surfaces.push_back(spline_surface(20, 10, [](double u, double v) {
        const double turn = 1.8 * M_PI * (u - 0.5), r = 0.5 + std::cos(turn);  // a limacon
        return Vec3(r * std::cos(turn) + v, r * std::sin(turn), 0.01 * v);
    }));
    const auto hits = find_loops(surfaces, 1e-4);
    REQUIRE(hits.size() == 1);
    CHECK(hits[0].surfaces[0] == 3);
    check_closes(surfaces[3], hits[0]);
}

TEST_CASE("narrow tongues are told from loops", "[measure][oracle]") {
    // Lines along u lead to the tip of the tongue, and back beside where they came from.
    for (const double width : {1.0, 0.1, 0.01}) {
        CAPTURE(width);
        const auto tongue = spline_surface(10, 10, [=](double u, double v) {
            const double depth = 50.0 * u * (1.0 - u) * (1.0 - v) * (1.0 - v);
            return Vec3(width * u, depth, 50.0 * v - 0.5 * depth);
        });
        CHECK(find_self_intersections({tongue}, 1e-4).empty());
    }
}

TEST_CASE("a narrow face of a fan that passes through its neighbour", "[measure][oracle]") {
    constexpr int faces = 96;
    constexpr double width = 2 * M_PI / faces;
    // Four-sided, from the tip of a cone to its rim.
    const auto face = [](double middle, double tilt) {
        const auto at = [&](double radius, double side) {
            const double a = middle + 0.5 * width * side;
            return Vec3(radius * std::cos(a), radius * std::sin(a), (tilt * side - 0.5) * radius);
        };
        const Vec3 tip = Vec3::Zero(), right = at(100.0, -1.0), left = at(100.0, 1.0),
                   far = at(130.0, 0.0);
        geom::BsplineSurface s{test::uniform_knots(1), test::uniform_knots(1), geom::Points(16, 3)};
        for (Eigen::Index i = 0; i < 4; ++i) {
            for (Eigen::Index j = 0; j < 4; ++j) {
                const double u = double(i) / 3.0, v = double(j) / 3.0;
                s.point(i, j) = ((1 - u) * (1 - v) * tip + u * (1 - v) * right + u * v * far +
                                 (1 - u) * v * left)
                                    .transpose();
            }
        }
        return s;
    };
    std::vector<geom::BsplineSurface> fan;
    for (int k = 0; k < faces; ++k) fan.push_back(face(width * k, 0.0));
    CHECK(find_self_intersections(fan, 0.01).empty());
    fan[40] = face(width * 41, 0.01);
    const auto hits = find_self_intersections(fan, 0.01);
    REQUIRE(hits.size() == 1);
    CHECK(hits[0].surfaces == std::array{40, 41});
    CHECK(hits[0].is_found);
    CHECK(std::atan2(hits[0].point.y(), hits[0].point.x()) == Approx(width * 41));
}

TEST_CASE("faces twice around a corner cross though each of its turns is sound",
          "[measure][oracle]") {
    constexpr int faces = 64;
    constexpr double width = 4 * M_PI / faces;
    // z = r sin(a / 2) / 2 over two turns: the sheets meet at angle 0 only.
    const auto face = [](double middle) {
        const auto at = [&](double radius, double side) {
            const double a = middle + 0.5 * width * side;
            return Vec3(radius * std::cos(a), radius * std::sin(a), 0.5 * radius * std::sin(a / 2));
        };
        const Vec3 right = at(100.0, -1.0), left = at(100.0, 1.0), far = at(130.0, 0.0);
        return spline_surface(1, 1, [=](double u, double v) {
            return Vec3(u * (1 - v) * right + u * v * far + (1 - u) * v * left);
        });
    };
    std::vector<geom::BsplineSurface> turns;
    for (int k = 0; k < faces; ++k) turns.push_back(face(width * k));
    const auto hits = find_self_intersections(turns, 0.01);
    REQUIRE(hits.size() == 1);
    CHECK(hits[0].surfaces == std::array{0, faces / 2});
    CHECK(std::abs(hits[0].point.y()) < 0.01);
}

TEST_CASE("the place of a self-intersection does not depend on threads", "[measure]") {
    const auto crossing = wing(20.0, -100.0, 0.0);
    const std::vector<geom::BsplineSurface> surfaces(3, crossing);
    base::set_thread_count(1);
    const auto one = find_loops(surfaces, 0.1);
    base::set_thread_count(0);
    const auto all = find_loops(surfaces, 0.1);
    REQUIRE(one.size() == 3);
    REQUIRE(all.size() == 3);
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(one[k].point == all[k].point);
        CHECK(one[k].uv == all[k].uv);
    }
}

TEST_CASE("surfaces that cross are told from those that meet along their sides",
          "[measure][oracle]") {
    constexpr double tolerance = 1e-2;
    const auto plane = [](const Vec3& at, const Vec3& along_u, const Vec3& along_v) {
        return spline_surface(
            6, 6, [=](double u, double v) { return Vec3(at + u * along_u + v * along_v); });
    };
    const auto pairs = [&](const std::vector<geom::BsplineSurface>& surfaces) {
        std::vector<std::array<int, 2>> result;
        for (const auto& hit : find_self_intersections(surfaces, tolerance)) {
            result.push_back(hit.surfaces);
            for (std::size_t k = 0; k < 2; ++k) {
                const auto& s = surfaces[std::size_t(hit.surfaces[k])];
                CHECK((s.at(hit.uv[k][0], hit.uv[k][1]).position - hit.point).norm() < 1e-6);
            }
        }
        return result;
    };
    const auto ground = plane(Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(0, 10, 0));
    // A wall on a side, one on half a side, one in the middle, one that stops short of the ground.
    const auto on_side = plane(Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(0, 0, 4));
    const auto on_half = plane(Vec3(0, 0, 0), Vec3(0, 5, 0), Vec3(0, 1, -4));
    const auto through = plane(Vec3(2, 2, -1), Vec3(5, 1, 0), Vec3(0, 0.3, 4));
    const auto above = plane(Vec3(2, 2, 2 * tolerance), Vec3(5, 1, 0), Vec3(0, 0.3, 4));
    CHECK(pairs({ground, on_side, on_half, above}).empty());
    CHECK(pairs({ground, on_side, through}) == std::vector<std::array<int, 2>>{{0, 2}});
    // Into each other by less than the resolution and by more.
    const auto sunk = [&](double depth) {
        return plane(Vec3(2, 2, -depth), Vec3(5, 1, 0), Vec3(0, 0.3, 4));
    };
    CHECK(pairs({ground, sunk(0.5 * tolerance)}).empty());
    CHECK(pairs({ground, sunk(3.0 * tolerance)}).size() == 1);
    // Coplanar neighbours, and around a corner of five curved sheets.
    CHECK(pairs({ground, plane(Vec3(10, 0, 0), Vec3(10, 3, 0), Vec3(0, 10, 0))}).empty());
    std::vector<geom::BsplineSurface> sheets;
    for (int k = 0; k < 5; ++k)
        sheets.push_back(spline_surface(8, 8, [k](double u, double v) {
            const double angle = 2 * M_PI * (k + v) / 5, r = 20.0 * u;
            return Vec3(r * std::cos(angle), r * std::sin(angle), 0.02 * r * r);
        }));
    CHECK(pairs(sheets).empty());
    // A wing's two sheets, sharp at the trailing edge; lifted at mid chord they pass through each
    // other.
    const auto sheet = [](double side, double sink) {
        return spline_surface(30, 8, [=](double u, double v) {
            const double camber = 30.0 * u * (1.0 - u) - sink * side * u * u * (1.0 - u);
            return Vec3(1000.0 * u * u, 900.0 * v,
                        camber + side * 60.0 * u * (1.0 - u) * (1.0 - u * u));
        });
    };
    CHECK(pairs({sheet(1.0, 0.0), sheet(-1.0, 0.0)}).empty());
    CHECK(pairs({sheet(1.0, 90.0), sheet(-1.0, 90.0)}).size() == 1);
}
