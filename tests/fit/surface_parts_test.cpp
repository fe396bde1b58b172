#include "fit/match/surface_parts.h"

#include "fit/loop/projector.h"
#include "support/cages.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <map>

using namespace patchwright;
using geom::Vec3;

namespace {

const Vec3 size(100.0, 100.0, 10.0);

/// The box from the origin to `size` with n x n quads a side and sharp edges.
struct BoxCage {
    mesh::Cage cage;
    std::vector<Vec3> normals;  ///< one a face

    /// @param smooth  whether the edge at the middle of which this point is stays smooth
    explicit BoxCage(int n, const std::optional<Vec3>& smooth = std::nullopt) {
        std::map<std::array<int, 3>, int> number;
        std::vector<Vec3> points;
        std::vector<std::vector<int>> faces;
        const auto vertex = [&](const std::array<int, 3>& at) {
            const auto [it, added] = number.emplace(at, int(points.size()));
            if (added) points.push_back(Vec3(at[0], at[1], at[2]).cwiseProduct(size) / n);
            return it->second;
        };
        for (int axis = 0; axis < 3; ++axis)
            for (const bool upper : {false, true})
                for (int i = 0; i < n; ++i)
                    for (int j = 0; j < n; ++j) {
                        std::vector<int> face;
                        for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
                            std::array<int, 3> at{};
                            at[std::size_t(axis)] = upper ? n : 0;
                            at[std::size_t((axis + 1) % 3)] = i + u;
                            at[std::size_t((axis + 2) % 3)] = j + v;
                            face.push_back(vertex(at));
                        }
                        if (!upper) std::reverse(face.begin(), face.end());
                        faces.push_back(face);
                        normals.push_back(Vec3::Unit(axis) * (upper ? 1.0 : -1.0));
                    }
        cage = test::make_cage(points, faces, creases(points, faces, smooth));
    }

    static mesh::TopologyInput creases(const std::vector<Vec3>& points,
                                       const std::vector<std::vector<int>>& faces,
                                       const std::optional<Vec3>& smooth) {
        mesh::TopologyInput tags;
        const auto on_sides = [&](const Vec3& p) {
            return (p.array() <= 0.0).count() + (p.array() >= size.array()).count();
        };
        for (const auto& face : faces)
            for (std::size_t k = 0; k < 4; ++k) {
                const int a = face[k], b = face[(k + 1) % 4];
                const Vec3 middle = 0.5 * (points[std::size_t(a)] + points[std::size_t(b)]);
                if (a < b && on_sides(middle) == 2 && !(smooth && middle == *smooth))
                    tags.creases.push_back({a, b, mesh::infinite_sharpness});
            }
        return tags;
    }
};

fit::SurfaceParts parts_of(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    const fit::CurveSampling curves = fit::curve_sites(*cage.topology);
    const fit::FitOptions options;
    const fit::FeatureMatch match = fit::match_cage(
        cage, curves, fit::curve_points(cage, curves, options.solver.samples_per_edge), reference,
        options);
    return {*cage.topology, curves, match, reference};
}

}  // namespace

TEST_CASE("creases part a cage as their curves part the model", "[fit]") {
    const geom::MeshReference box(test::triangle_box(size.x(), size.y(), size.z()));
    const int n = GENERATE(1, 2);
    // One edge that the cage rounds off: neither parts the two sides beside it.
    const bool rounded = GENERATE(false, true);
    const Vec3 edge(size.x(), 0.5 * size.y(), size.z());
    if (n == 2 && rounded) return;  // that edge's middle is a vertex
    const BoxCage shape(n, rounded ? std::optional(edge) : std::nullopt);
    const fit::SurfaceParts parts = parts_of(shape.cage, box);
    for (int f = 0; f < shape.cage.topology->face_count(); ++f) {
        const std::vector<char>* part = parts.part_of(mesh::FaceId{f});
        REQUIRE(part != nullptr);
        const Vec3& normal = shape.normals[std::size_t(f)];
        for (std::size_t t = 0; t < part->size(); ++t) {
            const Vec3 other = box.point_on_face(int(t), {0.3, 0.3}).normal;
            const bool beside_edge =
                rounded && normal.dot(Vec3(1, 0, 1)) > 0.5 && other.dot(Vec3(1, 0, 1)) > 0.5;
            CHECK(((*part)[t] != 0) == (other.dot(normal) > 0.5 || beside_edge));
        }
    }
}

TEST_CASE("a cage without creases, or a model without curves, is all of one part", "[fit]") {
    const geom::MeshReference box(test::triangle_box(size.x(), size.y(), size.z()));
    CHECK(parts_of(test::cube(100.0), box).part_of(mesh::FaceId{0}) == nullptr);
    const geom::MeshReference sphere(test::triangle_sphere(50.0, 24));
    CHECK(parts_of(BoxCage(1).cage, sphere).part_of(mesh::FaceId{0}) == nullptr);
}

TEST_CASE("what has sunk into a thin part belongs to its own side", "[fit]") {
    // The narrow side at x = 100 is bent in by 60 mm where the box is 10 mm high: top and bottom
    // are nearest there.
    const geom::MeshReference box(test::triangle_box(size.x(), size.y(), size.z()));
    const BoxCage shape(2);
    geom::Points sunk = shape.cage.points;
    const Vec3 middle(size.x(), 0.5 * size.y(), 0.5 * size.z());
    for (Eigen::Index v = 0; v < sunk.rows(); ++v)
        if (sunk.row(v).transpose() == middle) sunk(v, 0) = 40.0;
    constexpr double any_reach = std::numeric_limits<double>::infinity();
    const fit::Projector projector(shape.cage, box, {.tolerance_mm = 0.01}, any_reach, [] {});
    const fit::Projection p = projector.project_surface(sunk, nullptr);
    const auto& rows = projector.face_samples().site_rows();
    double deepest = size.x();
    for (int f = 0; f < shape.cage.topology->face_count(); ++f) {
        if (shape.normals[std::size_t(f)].x() < 0.5) continue;
        for (auto i = rows[std::size_t(f)]; i < rows[std::size_t(f) + 1]; ++i) {
            deepest = std::min(deepest, p.limit(i, 0));
            CHECK(p.target(i, 0) == Approx(size.x()));
        }
    }
    CHECK(deepest < size.x() - 20.0);
}

TEST_CASE("a side that has sunk into a thin part is fitted to where it belongs", "[fit]") {
    const geom::MeshReference box(test::triangle_box(size.x(), size.y(), size.z()));
    BoxCage shape(4);
    for (Eigen::Index v = 0; v < shape.cage.points.rows(); ++v) {
        const Vec3 p = shape.cage.points.row(v).transpose();
        if (p.x() == size.x() && p.y() > 0.0 && p.y() < size.y() && p.z() > 0.0 && p.z() < size.z())
            shape.cage.points(v, 0) = 70.0;
    }
    const fit::FitResult fitted =
        fit::fit(shape.cage, box, {.tolerance_mm = 0.01, .max_levels = 0});
    CHECK(fitted.levels.back().largest() < 0.01);
}
