#include "cage/field/merge_singularities.h"

#include "field_shape.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

namespace patchwright {
namespace {

using geom::Vec3;
using test::Field;
using test::Outline;
using test::prism;

cage::Poll no_limit;  // never stops

/// A square plate with a hole like a wing's section, 12 long: its nose, at x = 6, is rounded within
/// less than a triangle of the field, its tail is pointed.
geom::TriangleMesh plate_with_section() {
    constexpr int side = 24;
    constexpr double half = 20.0, length = 12.0, thickness = 1.0;
    std::vector<Eigen::Vector2d> inner, outer;
    for (int i = -side; i < side; ++i) {
        const double s = std::pow(double(i) / side, 2.0);
        inner.emplace_back(length * (0.5 - s),
                           std::copysign(thickness, i) * std::sqrt(s) * (1.0 - s));
        const Eigen::Vector2d& p = inner.back();
        outer.push_back(p * half / p.cwiseAbs().maxCoeff());
    }
    for (const auto& [x, y] : {std::pair{half, half}, {-half, half}, {-half, -half}, {half, -half}})
        *std::min_element(outer.begin(), outer.end(), [&](const auto& a, const auto& b) {
            return (a - Eigen::Vector2d(x, y)).norm() < (b - Eigen::Vector2d(x, y)).norm();
        }) = {x, y};
    Outline plate;
    const int n = int(inner.size());
    plate.points = inner;
    plate.points.insert(plate.points.end(), outer.begin(), outer.end());
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        plate.triangles.push_back({i, n + i, n + j});
        plate.triangles.push_back({i, n + j, j});
    }
    return prism(plate, 10.0);
}

/// Where z is as given, the field around points of the x axis with the indices 1/4 and -1/4.
void set_pair(const geom::EditableMesh& mesh, cage::CrossField& field, double z, double plus_x,
              double minus_x) {
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.alive(t)) continue;
        const auto& c = mesh.triangle(t);
        const Vec3 p = (mesh.point(c[0]) + mesh.point(c[1]) + mesh.point(c[2])) / 3.0;
        if (std::abs(p.z() - z) > 1e-9) continue;
        const double angle =
            0.25 * (std::atan2(p.y(), p.x() - plus_x) - std::atan2(p.y(), p.x() - minus_x));
        field.direction[std::size_t(t)] = Vec3(std::cos(angle), std::sin(angle), 0.0);
    }
}

TEST_CASE("a singularity beside a rim that turns sharply becomes part of it", "[field]") {
    Field made(plate_with_section());
    const Vec3 nose(6, 0, 10);
    const auto near_nose = [&] {
        int count = 0;
        for (const cage::Singularity& s : made.topology.singularities)
            count += (made.mesh.point(s.vertex) - nose).norm() < 1.5 ? 1 : 0;
        return count;
    };
    const auto quads_at_nose = [&] {
        int most = 0;
        for (const cage::FieldSector& s : made.topology.sectors)
            if ((made.mesh.point(s.vertex) - nose).norm() < 0.5) most = std::max(most, s.quads);
        return most;
    };
    const int quarters = made.quarters();
    CHECK(near_nose() == 1);
    CHECK(quads_at_nose() == 3);
    cage::merge_singularities(made.mesh, made.field, made.topology, 2.0, no_limit);
    CHECK(near_nose() == 0);
    // The rim turns by half a circle there.
    CHECK(quads_at_nose() == 4);
    CHECK(made.quarters() == quarters);
    CHECK(made.topology.mismatches.empty());
}

TEST_CASE("singularities of opposite indices that lie side by side are gone", "[field][oracle]") {
    Field made(prism({{{20, 20}, {-20, 20}, {-20, -20}, {20, -20}}, {{0, 1, 2}, {0, 2, 3}}}, 10.0));
    const std::size_t before = made.topology.singularities.size();
    // On the top, which has none.
    set_pair(made.mesh, made.field, 10.0, 2.0, -2.0);
    made.topology = cage::field_topology(made.mesh, made.field);
    REQUIRE(made.topology.singularities.size() == before + 2);
    SECTION("within reach") {
        cage::merge_singularities(made.mesh, made.field, made.topology, 6.0, no_limit);
        CHECK(made.topology.singularities.size() == before);
        CHECK(made.topology.mismatches.empty());
    }
    SECTION("out of reach") {
        cage::merge_singularities(made.mesh, made.field, made.topology, 3.0, no_limit);
        CHECK(made.topology.singularities.size() == before + 2);
    }
}

/// A square of 40 x 40 around the origin, two triangles each unit, with a feature curve from its
/// side at x = -20 to the origin.
geom::EditableMesh square_with_line() {
    constexpr int n = 41;
    geom::SurfaceMesh mesh;
    mesh.points.resize(n * n, 3);
    const auto id = [](int i, int j) { return n * j + i; };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) mesh.points.row(id(i, j)) << i - 20, j - 20, 0.0;
    for (int j = 0; j + 1 < n; ++j)
        for (int i = 0; i + 1 < n; ++i) {
            mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
            mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
        }
    mesh.faces.assign(mesh.triangles.size(), 0);
    mesh.corners.assign(std::size_t(n * n), -1);
    for (int i = 0; i < 20; ++i) mesh.features.push_back({id(i, 20), id(i + 1, 20), 0});
    geom::EditableMesh result(mesh);
    cage::open_corners(result);
    return result;
}

TEST_CASE("the end of a feature with four quads around it stays regular", "[field]") {
    const geom::EditableMesh mesh = square_with_line();
    cage::CrossField field;
    field.direction.assign(std::size_t(mesh.triangle_count()), Vec3::Zero());
    // In line with the feature, the first one near its end.
    set_pair(mesh, field, 0.0, 3.0, 13.0);
    cage::FieldTopology topology = cage::field_topology(mesh, field);
    REQUIRE(topology.singularities.size() == 2);
    cage::merge_singularities(mesh, field, topology, 5.0, no_limit);
    CHECK(topology.singularities.size() == 2);
}

}  // namespace
}  // namespace patchwright
