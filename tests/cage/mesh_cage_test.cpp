// Cages and fits from triangles against the shapes that the triangles stand for.
#include "geom/angle.h"
#include "support/triangle_shapes.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit.h>
#include <patchwright/geom/mesh_reference.h>
#include <patchwright/subd/limit_operator.h>

#include <catch2/catch.hpp>

#include <functional>

namespace patchwright {
namespace {

constexpr double tolerance_rel = 1e-3;

struct Fitted {
    geom::Points limit;  ///< points of the limit surface, 16 a face
    mesh::Cage cage;
    double tolerance = 0.0;
    double worst = 0.0;  ///< by the fit's samples, millimetres
};

Fitted fitted_to(const geom::MeshReference& reference) {
    Fitted result;
    result.tolerance = tolerance_rel * reference.bounds().diagonal();
    const auto made = cage::make_cage(
        reference, {.method = cage::Method::Remesh, .tolerance_rel = tolerance_rel});
    const fit::FitResult fitted = fit::fit(made.cage, reference,
                                           {.tolerance_mm = 0.8 * result.tolerance,
                                            .max_levels = 2,
                                            .preserve_parametrisation = false});
    result.cage = fitted.cage;
    const fit::FitLevel& level = fitted.levels[std::size_t(fitted.best_level)];
    result.worst = std::max(level.max_mm, level.curve_max_mm);
    std::vector<subd::Site> sites;
    const mesh::Topology& topology = *fitted.cage.topology;
    for (const mesh::FaceId f : topology.faces()) {
        const int sectors = topology.size(f) == 4 ? 1 : topology.size(f);
        for (int s = 0; s < sectors; ++s) sites.push_back({f, s, 0});
    }
    subd::ParameterSet grid;
    for (const double u : {0.1, 0.4, 0.6, 0.9})
        for (const double v : {0.1, 0.4, 0.6, 0.9}) grid.push_back({u, v});
    const subd::LimitOperator limit(topology, {grid}, sites, subd::SampleRows::Points);
    limit.apply(fitted.cage.points, result.limit);
    return result;
}

int creases(const mesh::Cage& cage) {
    int count = 0;
    for (const mesh::EdgeId e : cage.topology->edges())
        count += cage.topology->tagged_sharpness(e) > 0.0 ? 1 : 0;
    return count;
}

TEST_CASE("a triangulated sphere is fitted to the sphere", "[layout][mesh][oracle]") {
    constexpr double radius = 50.0;
    constexpr int around = 64;
    const geom::MeshReference sphere(test::triangle_sphere(radius, around));
    const Fitted fitted = fitted_to(sphere);
    CHECK(fitted.worst < fitted.tolerance);
    CHECK(creases(fitted.cage) == 0);
    // Triangles bend both ways, so chords count twice.
    const double chord = 2.0 * radius * (1.0 - std::cos(M_PI / around));
    for (Eigen::Index i = 0; i < fitted.limit.rows(); ++i)
        CHECK(std::abs(fitted.limit.row(i).norm() - radius) < chord + fitted.tolerance);
}

TEST_CASE("a triangulated box is fitted to the box, with its edges as creases",
          "[layout][mesh][oracle]") {
    const Eigen::Vector3d size(60, 40, 20);
    const geom::MeshReference box(test::triangle_box(size.x(), size.y(), size.z()));
    const Fitted fitted = fitted_to(box);
    CHECK(fitted.worst < 1e-9);
    CHECK(creases(fitted.cage) >= 12);
    for (Eigen::Index i = 0; i < fitted.limit.rows(); ++i) {
        // Distance from the nearest of the six planes.
        const Eigen::Vector3d p = fitted.limit.row(i);
        const double low = p.cwiseAbs().minCoeff(), high = (size - p).cwiseAbs().minCoeff();
        CHECK(std::min(low, high) < 1e-9);
    }
}

/// The faces at a vertex between two creases.
struct Sector {
    double angle = 0.0;
    int faces = 0;
};

std::vector<Sector> sectors_between_creases(const mesh::Cage& cage) {
    const mesh::Topology& t = *cage.topology;
    std::vector<Sector> sectors;
    for (const mesh::FaceId f : t.faces()) {
        for (const mesh::CornerId first : t.corners(f)) {
            if (t.tagged_sharpness(t.edge(first)) == 0.0) continue;
            sectors.emplace_back();
            for (mesh::CornerId c = first;;) {
                const auto at = [&](mesh::CornerId k) {
                    return geom::Vec3(cage.points.row(t.vertex(k).value));
                };
                sectors.back().angle +=
                    geom::angle_between(at(t.next(c)) - at(c), at(t.previous(c)) - at(c));
                ++sectors.back().faces;
                if (t.tagged_sharpness(t.edge(t.previous(c))) > 0.0) break;
                c = t.rotate(c);
            }
        }
    }
    return sectors;
}

TEST_CASE("concave corners of remeshed cages have three faces", "[layout][mesh]") {
    const geom::MeshReference bracket(test::triangle_bracket(60.0, 30.0, 15.0));
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const auto made =
            cage::make_cage(bracket, {.method = cage::Method::Remesh, .tolerance_rel = tolerance});
        int concave = 0;
        for (const Sector& sector : sectors_between_creases(made.cage)) {
            if (sector.angle < 3.7) continue;
            ++concave;
            CHECK(sector.faces >= 3);
        }
        CHECK(concave == 2);
    }
}

TEST_CASE("few triangles are left in remeshed cages", "[layout][mesh]") {
    const geom::MeshReference shapes[] = {
        geom::MeshReference(test::triangle_sphere(50.0, 64)),
        geom::MeshReference(test::triangle_cylinder(20.0, 60.0, 64)),
        geom::MeshReference(test::triangle_bracket(60.0, 30.0, 15.0))};
    for (const geom::MeshReference& shape : shapes) {
        // Fine enough that most faces are off the curves, where each vertex needs two faces.
        const auto made = cage::make_cage(shape, {.method = cage::Method::Remesh, .fineness = 4.0});
        const mesh::Topology& t = *made.cage.topology;
        int triangles = 0, faces = 0;
        for (const mesh::FaceId f : t.faces()) {
            triangles += t.size(f) == 3 ? 1 : 0;
            ++faces;
        }
        // Pairing alone leaves a third.
        CHECK(triangles <= faces / 8);
    }
}

TEST_CASE("vertices stay evenly spread along closed curves", "[layout][mesh][oracle]") {
    // Rims of slim ellipses: vertices must not gather at one of their ends. Edges span 84 degrees
    // at most: 63 by the size field, a third more until they are split.
    constexpr double radius = 20.0, flattening = 0.35;
    geom::TriangleMesh tube = test::triangle_cylinder(radius, 60.0, 64);
    tube.points.col(1) *= flattening;
    const geom::MeshReference reference(tube);
    const auto made = cage::make_cage(reference, {.method = cage::Method::Remesh});
    const mesh::Topology& t = *made.cage.topology;
    const auto tangent = [&](mesh::VertexId v) {
        const auto p = made.cage.points.row(v.value);
        return geom::Vec3(-p.y() / flattening, p.x() * flattening, 0.0);
    };
    for (const mesh::EdgeId e : t.edges())
        if (t.tagged_sharpness(e) > 0.0)
            CHECK(geom::angle_between(tangent(t.start(e)), tangent(t.end(e))) < 1.5);
}

TEST_CASE("a triangulated cylinder keeps its two rims", "[layout][mesh][oracle]") {
    constexpr double radius = 20.0, height = 60.0;
    constexpr int around = 64;
    const geom::MeshReference cylinder(test::triangle_cylinder(radius, height, around));
    const Fitted fitted = fitted_to(cylinder);
    CHECK(fitted.worst < fitted.tolerance);
    CHECK(creases(fitted.cage) >= 2 * 5);
    const double slack = radius * (1.0 - std::cos(M_PI / around)) + fitted.tolerance;
    for (Eigen::Index i = 0; i < fitted.limit.rows(); ++i) {
        const Eigen::Vector3d p = fitted.limit.row(i);
        const double side = std::abs(p.head<2>().norm() - radius);
        CHECK(std::min({side, std::abs(p.z()), std::abs(height - p.z())}) < slack);
    }
}

}  // namespace
}  // namespace patchwright
