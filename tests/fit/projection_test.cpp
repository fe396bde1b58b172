// Foot points of the samples of a fit.
#include "fit/loop/projector.h"
#include "support/cages.h"
#include "support/triangle_shapes.h"

#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

#include <array>
#include <limits>

namespace patchwright {
namespace {

/// Vertices of a grid of 4 x 4 quads on the top of a box, 20 mm above its bottom.
geom::Points on_top(const std::array<double, 5>& x) {
    geom::Points points(25, 3);
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) points.row(5 * i + j) << x[std::size_t(i)], 1.0 + 2.0 * j, 20.0;
    return points;
}

}  // namespace

TEST_CASE("samples of a fold keep their foot points beside it", "[fit]") {
    const geom::MeshReference box(test::triangle_box(10.0, 10.0, 20.0));
    mesh::Cage cage = test::grid(4, 4);
    cage.points = on_top({1.0, 4.8, 5.0, 5.2, 9.0});
    constexpr double any_reach = std::numeric_limits<double>::infinity();
    fit::Projector projector(cage, box, {.tolerance_mm = 0.01}, any_reach, [] {});
    // Limit points of the middle lines are at 5.67, 5 and 4.33: the faces between, 0.8 by 2 mm
    // before, face down, as the bottom does.
    const auto folded = projector.project_surface(on_top({1.0, 7.0, 5.0, 3.0, 9.0}), nullptr);
    CHECK(folded.normals.col(2).minCoeff() < 0.0);
    CHECK(folded.distances.max < 1e-9);
}

}  // namespace patchwright
