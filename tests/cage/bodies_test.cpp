#include "support/cages.h"

#include <patchwright/cage/bodies.h>
#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/patch/extract.h>

#include <catch2/catch.hpp>

namespace patchwright {
namespace {

/// Two sharp cubes with edges of 2 mm, of which one sticks in the other.
occ::CadModel crossing_cubes() {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i)
            if (face[i] < face[(i + 1) % 4])
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
    }
    const mesh::Cage one = test::cube(2.0, tags);
    mesh::Cage other = one;
    other.points.rowwise() += Eigen::RowVector3d(1.2, 0.1, 0.2);
    return occ::assemble(patch::extract(mesh::joined({one, other})).patches);
}

TEST_CASE("parts of a cage are fitted to the bodies that they lie on", "[layout]") {
    const occ::CadModel model = crossing_cubes();
    const occ::CadReference whole(model);
    const auto bodies = occ::body_references(model);
    REQUIRE(bodies.size() == 2);
    CHECK(bodies[0].faces.size() == 6);
    CHECK(bodies[0].surface->features().corners.size() == 8);

    const auto made = cage::make_cage(whole, {.method = cage::Method::Remesh}).cage;
    const auto parts = mesh::connected_parts(made);
    REQUIRE(parts.size() == 2);
    const auto references = cage::references_of_parts(parts, bodies, whole);
    CHECK(references[0] != references[1]);
    for (const auto* r : references) {
        const bool is_body = r == bodies[0].surface.get() || r == bodies[1].surface.get();
        CHECK(is_body);
    }
    // Flat faces between sharp edges: the limit surface can be the model.
    const fit::FitOptions options{
        .tolerance_mm = 1e-6, .max_levels = 0, .preserve_parametrisation = false};
    const auto fitted = fit::fit_parts(parts, references, options);
    CHECK(fitted.whole.within_tolerance);
    CHECK(fitted.whole.levels.size() == 1);
    CHECK(fitted.whole.levels[0].vertices == made.topology->vertex_count());
    CHECK(fitted.whole.cage.topology->face_count() == made.topology->face_count());

    // What is known is taken as it is; anything else is fitted.
    auto known = fitted.parts;
    known[1].result.cage.points.setZero();
    const auto again = fit::fit_parts(parts, references, options, known);
    CHECK(again.parts[0].result.cage.points == fitted.parts[0].result.cage.points);
    CHECK(again.parts[1].result.cage.points.isZero());
    fit::FitOptions tighter = options;
    tighter.tolerance_mm = 1e-7;
    CHECK_FALSE(
        fit::fit_parts(parts, references, tighter, known).parts[1].result.cage.points.isZero());
}

TEST_CASE("parts of a cage on the same body are fitted together", "[layout]") {
    const occ::CadModel model = crossing_cubes();
    const auto bodies = occ::body_references(model);
    // The three faces around one corner of the first cube, and the three around the opposite one.
    const auto half = [](const std::vector<std::size_t>& faces) {
        std::vector<int> number(8, -1);
        std::vector<geom::Vec3> points;
        std::vector<std::vector<int>> renumbered;
        for (const std::size_t f : faces) {
            renumbered.emplace_back();
            for (const int v : test::cube_faces[f]) {
                int& n = number[std::size_t(v)];
                if (n < 0) {
                    n = int(points.size());
                    points.emplace_back(test::cube(2.0).points.row(v));
                }
                renumbered.back().push_back(n);
            }
        }
        return test::make_cage(points, renumbered);
    };
    const auto* body = bodies[0].surface.get();
    const fit::FitOptions options{
        .tolerance_mm = 0.1, .max_levels = 0, .preserve_parametrisation = false};
    const auto fitted = fit::fit_parts({half({0, 2, 4}), half({1, 3, 5})}, {body, body}, options);
    REQUIRE(fitted.parts.size() == 1);
    CHECK(fitted.parts[0].given.topology->face_count() == 6);
    // Either half alone stays more than 1 mm away from the other's corner.
    CHECK(fitted.whole.levels[0].reverse_max_mm < 0.9);
}

TEST_CASE("a part of a cage that covers several bodies is fitted to the whole model", "[layout]") {
    const occ::CadModel model = crossing_cubes();
    const occ::CadReference whole(model);
    const auto bodies = occ::body_references(model);
    mesh::Cage around = test::cube(2.0);
    around.points.col(0) = around.points.col(0).array() * 1.6 + 0.6;
    const auto references = cage::references_of_parts({around}, bodies, whole);
    REQUIRE(references.size() == 1);
    CHECK(references[0] == &whole);
}

}  // namespace
}  // namespace patchwright
