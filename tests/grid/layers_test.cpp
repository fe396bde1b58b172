#include "grid/sample_cage.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/layers.h>
#include <patchwright/grid/quality.h>

#include <catch2/catch.hpp>

#include <cmath>

namespace patchwright {
namespace {

using grid::LayerGrid;
using grid::Plan;

/// An L of three cubes, every edge sharp: convex and concave edges and corners of valence 3 to 6.
mesh::Cage corner_block() {
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    const auto vertex = [&](int x, int y, int z) {
        const geom::Vec3 p(x, y, z);
        for (std::size_t k = 0; k < points.size(); ++k) {
            if (points[k] == p) return int(k);
        }
        points.push_back(p);
        return int(points.size()) - 1;
    };
    const auto filled = [](int x, int y, int z) {
        return z == 0 && x >= 0 && y >= 0 && x < 2 && y < 2 && !(x == 1 && y == 1);
    };
    for (int x = 0; x < 2; ++x) {
        for (int y = 0; y < 2; ++y) {
            if (!filled(x, y, 0)) continue;
            for (int axis = 0; axis < 3; ++axis) {
                for (const int end : {0, 1}) {
                    int at[3] = {x, y, 0};
                    at[axis] += end == 1 ? 1 : -1;
                    if (filled(at[0], at[1], at[2])) continue;
                    std::vector<int> face;
                    for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
                        int corner[3] = {x, y, 0};
                        corner[axis] += end;
                        corner[(axis + 1) % 3] += a;
                        corner[(axis + 2) % 3] += b;
                        face.push_back(vertex(corner[0], corner[1], corner[2]));
                    }
                    if (end == 0) std::reverse(face.begin(), face.end());
                    faces.push_back(face);
                }
            }
        }
    }
    mesh::TopologyInput tags;
    for (std::size_t v = 0; v < points.size(); ++v) {
        for (std::size_t w = v + 1; w < points.size(); ++w) {
            const geom::Vec3 d = points[w] - points[v];
            if (d.norm() > 1.1) continue;
            // Edges between coplanar faces stay smooth.
            const geom::Vec3 m = 0.5 * (points[v] + points[w]);
            const bool on_top_seam =
                d.z() == 0.0 && m.x() > 0.0 && m.y() > 0.0 && !(m.x() == 2.0 || m.y() == 2.0) &&
                ((m.x() == 1.0 && m.y() < 1.0) || (m.y() == 1.0 && m.x() < 1.0));
            const bool on_side_seam =
                d.z() != 0.0 && ((m.x() == 0.0 && m.y() == 1.0) || (m.x() == 1.0 && m.y() == 0.0));
            if (!on_top_seam && !on_side_seam) tags.creases.push_back({int(v), int(w), 10.0});
        }
    }
    return test::make_cage(points, faces, tags);
}

void check_layers(const mesh::Cage& cage, double size_share, double first_share, int cells,
                  double growth, bool may_thin) {
    const double diagonal = geom::bounding_box(cage.points).diagonal();
    const Plan plan = grid::make_plan(grid::make_layout(cage), {.size_mm = size_share * diagonal});
    const LayerGrid layers(plan,
                           {.cells = cells, .growth = growth, .first_mm = first_share * diagonal});
    const grid::GridQuality q = grid::measure_quality(layers);
    CAPTURE(q.scaled_jacobian->worst, q.scaled_jacobian->at.transpose(), q.scaled_jacobian->k,
            layers.thinnest());
    CHECK(q.negative == 0);
    CHECK(layers.layers() == cells + 1);
    CHECK(q.scaled_jacobian->mean > 0.6);
    // What checks of solvers want of every cell.
    CHECK(q.scaled_jacobian->worst > 0.02);
    CHECK(q.stretching.worst < 5.0);
    if (!may_thin) CHECK(layers.thinnest() > 0.5);
}

TEST_CASE("layers have no negative volumes", "[grid]") {
    check_layers(test::cube(2.0), 0.03, 1e-4, 30, 1.25, false);
    check_layers(test::torus(8, 6, 3.0, 1.0), 0.02, 1e-3, 20, 1.1, false);
    check_layers(test::sample_cage("cages/genus2.obj"), 0.02, 1e-4, 20, 1.2, true);  // valence 5
    check_layers(test::sample_cage("cages/cube_rim.obj"), 0.03, 1e-4, 25, 1.2,
                 true);  // convex edges
    check_layers(test::sample_cage("cages/dish.obj"), 0.03, 1e-4, 20, 1.2, true);
    check_layers(test::sample_cage("wing/wing_cage.obj"), 0.02, 1e-5, 30, 1.2, true);
    check_layers(corner_block(), 0.03, 1e-4, 25, 1.2, true);  // concave edge
    // A duct that the layers would fill more than whole, and a junction of valence 5.
    check_layers(test::sample_cage("engine/cage.obj"), 0.03, 1.5e-4, 30, 1.2, true);
    check_layers(test::sample_cage("wing_fuselage/cage.obj"), 0.015, 1.5e-4, 28, 1.2, true);
    check_layers(test::sample_cage("wing_tip/cage.obj"), 0.02, 4e-4, 30, 1.2, true);
}

TEST_CASE("layers much thicker than the wing's cells have no negative volumes", "[grid]") {
    // 591 mm on cells of 15 mm, round a tip of 45 mm and noses of valence 3.
    const Plan plan = grid::make_plan(grid::make_layout(test::sample_cage("wing/wing_cage.obj")),
                                      {.size_mm = 15.0});
    const LayerGrid layers(plan, {.cells = 30, .growth = 1.2, .first_mm = 0.5});
    const grid::GridQuality q = grid::measure_quality(layers);
    CHECK(q.negative == 0);
    CHECK(q.scaled_jacobian->mean > 0.9);
    CHECK(q.scaled_jacobian->worst > 0.02);
    CHECK(q.stretching.worst < 5.0);
}

TEST_CASE("a fold in the surface spoils the layers there only", "[grid]") {
    mesh::Cage cage = test::grid(12, 12);
    const geom::Vec3 row = cage.points.row(13 * 6 + 6), next = cage.points.row(13 * 6 + 7);
    cage.points.row(13 * 6 + 6) = 5.0 * next - 4.0 * row;
    const Plan plan = grid::make_plan(grid::make_layout(cage), {.cells = 48});
    const std::int64_t folded = grid::measure_quality(grid::SurfaceGrid(plan)).folded;
    const LayerGrid layers(plan, {.cells = 20, .growth = 1.2, .first_mm = 0.01});
    const grid::GridQuality q = grid::measure_quality(layers);
    CAPTURE(folded, q.negative, q.cells);
    CHECK(folded > 0);
    CHECK(q.negative > 0);
    CHECK(q.negative < q.cells / 20);
}

TEST_CASE("layers of a flat grid have the heights asked for", "[grid][oracle]") {
    mesh::TopologyInput tags;
    tags.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    const Plan plan = grid::make_plan(grid::make_layout(test::grid(3, 3, tags)), {.cells = 6});
    const LayerGrid layers(plan, {.cells = 5, .growth = 1.5, .first_mm = 0.02});
    grid::BlockPoints p;
    layers.evaluate(0, p);
    for (int k = 0; k < p.nk; ++k) {
        const double height = 0.02 * (std::pow(1.5, k) - 1.0) / 0.5;
        CHECK(p.at(3, 3, k).z() == Approx(height).margin(1e-12));
        CHECK(p.at(3, 3, k).x() == Approx(p.at(3, 3, 0).x()).epsilon(1e-3));
    }
    const LayerGrid thick(plan, {.cells = 4, .growth = 2.0, .thickness_mm = 1.5});
    thick.evaluate(0, p);
    CHECK(p.at(2, 2, 1).z() == Approx(0.1));
    CHECK(p.at(2, 2, 4).z() == Approx(1.5));
}

TEST_CASE("blocks of layers meet to the last bit", "[grid]") {
    const Plan plan = grid::make_plan(grid::make_layout(test::cube(2.0)), {.cells = 8});
    const LayerGrid layers(plan, {.cells = 6, .first_mm = 0.02});
    std::vector<grid::BlockPoints> blocks(6);
    for (int b = 0; b < 6; ++b) layers.evaluate(b, blocks[std::size_t(b)]);
    // Every border point of a block is a border point of another.
    for (const auto& p : blocks) {
        for (int k = 0; k < p.nk; ++k) {
            for (int i = 0; i < p.ni; ++i) {
                int found = 0;
                for (const auto& q : blocks) {
                    for (int n = 0; n < q.ni; ++n) {
                        for (const auto& [a, b] :
                             {std::pair{n, 0}, {n, q.nj - 1}, {0, n}, {q.ni - 1, n}}) {
                            found += (q.at(a, b, k).array() == p.at(i, 0, k).array()).all() ? 1 : 0;
                        }
                    }
                }
                CHECK(found >= 2);
            }
        }
    }
}

TEST_CASE("points of a planar border stay in its plane", "[grid]") {
    // Half a tube that stands on z = 0 and z = 2.
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    for (int k = 0; k < 8; ++k) {
        for (int l = 0; l < 3; ++l)
            points.emplace_back(std::cos(M_PI * k / 4), std::sin(M_PI * k / 4), l);
    }
    for (int k = 0; k < 8; ++k) {
        for (int l = 0; l < 2; ++l) {
            const int m = (k + 1) % 8;
            faces.push_back({3 * k + l, 3 * m + l, 3 * m + l + 1, 3 * k + l + 1});
        }
    }
    const Plan plan =
        grid::make_plan(grid::make_layout(test::make_cage(points, faces)), {.cells = 8});
    const LayerGrid layers(plan, {.cells = 8, .growth = 1.3, .first_mm = 0.05});
    grid::BlockPoints p;
    int on_plane = 0;
    for (int b = 0; b < layers.block_count(); ++b) {
        layers.evaluate(b, p);
        for (int i = 0; i < p.ni; ++i) {
            for (int j = 0; j < p.nj; ++j) {
                const double z = p.at(i, j).z();
                if (std::abs(z) > 1e-12 && std::abs(z - 2.0) > 1e-12) continue;
                ++on_plane;
                for (int k = 0; k < p.nk; ++k) CHECK(p.at(i, j, k).z() == Approx(z).margin(1e-9));
            }
        }
    }
    CHECK(on_plane > 16);
}

TEST_CASE("impossible layers are refused", "[grid]") {
    const Plan plan = grid::make_plan(grid::make_layout(test::cube(2.0)), {.cells = 2});
    CHECK_THROWS_AS(LayerGrid(plan, {.cells = 0, .first_mm = 0.1}), base::InvalidArgument);
    CHECK_THROWS_AS(LayerGrid(plan, {.cells = 2}), base::InvalidArgument);
    CHECK_THROWS_AS(LayerGrid(plan, {.cells = 2, .growth = -1.0, .first_mm = 0.1}),
                    base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
