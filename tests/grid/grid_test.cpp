#include "grid/sample_cage.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/evaluate.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

namespace patchwright {
namespace {

using grid::BlockCovering;
using grid::BlockLayout;
using grid::BlockPoints;
using grid::Plan;

/// Cages with every kind of neighbourhood.
std::vector<mesh::Cage> cages() {
    std::vector<mesh::Cage> all{test::cube(2.0),
                                test::torus(8, 6, 3.0, 1.0),
                                test::grid(3, 4),
                                test::fan(5),
                                test::sample_cage("wing/wing_cage.obj"),
                                test::sample_cage("cages/genus2.obj"),
                                test::sample_cage("cages/dish.obj"),
                                test::sample_cage("cages/cube_rim.obj"),
                                test::sample_cage("d150_wing/cage.obj")};
    for (unsigned seed = 0; seed < 6; ++seed) {
        all.push_back(test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = true}));
    }
    return all;
}

/// Every face once, every edge used in opposite directions, opposite sides alike.
void check_layout(const BlockLayout& layout) {
    const mesh::Topology& t = *layout.cage.topology;
    std::set<mesh::FaceId> seen;
    for (const grid::Block& block : layout.blocks) {
        REQUIRE(block.cells.size() == std::size_t(block.columns) * std::size_t(block.rows));
        for (const mesh::CornerId c : block.cells) CHECK(seen.insert(t.face(c)).second);
        for (std::size_t side = 0; side < 4; ++side) {
            CHECK(block.sides[side].size() == block.sides[(side + 2) % 4].size());
            std::size_t length = 0;
            for (const grid::BlockEdgeUse& use : block.sides[side]) {
                length += layout.edges[std::size_t(use.edge)].run.size();
            }
            CHECK(length == std::size_t(side % 2 == 0 ? block.columns : block.rows));
        }
    }
    CHECK(seen.size() == std::size_t(t.face_count()));
    const auto places = grid::edge_places(layout);
    for (std::size_t e = 0; e < places.size(); ++e) {
        const auto& run = layout.edges[e].run;
        const bool free = !t.twin(run.front()).valid();
        REQUIRE(places[e].size() == (free ? 1 : 2));
        std::set<bool> directions;
        for (const grid::EdgePlace& p : places[e]) {
            directions.insert(layout.blocks[std::size_t(p.block)]
                                  .sides[std::size_t(p.side)][std::size_t(p.use)]
                                  .reversed);
        }
        CHECK(directions.size() == places[e].size());
    }
}

TEST_CASE("blocks cover cages and meet one to one", "[grid]") {
    for (const mesh::Cage& cage : cages()) {
        for (const auto covering :
             {BlockCovering::Groups, BlockCovering::Charts, BlockCovering::Faces}) {
            const BlockLayout layout = grid::make_layout(cage, covering);
            check_layout(layout);
            for (const grid::Block& block : layout.blocks) {
                for (const auto& side : block.sides) CHECK(side.size() == 1);
            }
            check_layout(grid::join_all(layout));
        }
    }
}

TEST_CASE("blocks are as few as shapes allow", "[grid]") {
    CHECK(grid::make_layout(test::cube(2.0)).blocks.size() == 6);
    CHECK(grid::make_layout(test::torus(8, 6, 3.0, 1.0)).blocks.size() == 4);
    CHECK(grid::make_layout(test::grid(3, 4)).blocks.size() == 1);
    CHECK(grid::make_layout(test::grid(3, 4), BlockCovering::Faces).blocks.size() == 12);
    // The joined torus is one block whose opposite sides meet.
    CHECK(grid::join_all(grid::make_layout(test::torus(8, 6, 3.0, 1.0))).blocks.size() == 1);
}

TEST_CASE("blocks are not joined across creases", "[grid]") {
    int creases = 0;
    for (const char* name : {"cages/cube_rim.obj", "engine/cage.obj", "d150_wing/cage.obj"}) {
        CAPTURE(name);
        const BlockLayout layout = grid::join_all(grid::make_layout(test::sample_cage(name)));
        const mesh::Topology& t = *layout.cage.topology;
        std::set<mesh::EdgeId> between;
        for (const grid::BlockEdge& edge : layout.edges)
            for (const mesh::CornerId c : edge.run) between.insert(t.edge(c));
        for (const mesh::EdgeId e : t.edges()) {
            if (!(t.sharpness(e) > 0.0)) continue;
            ++creases;
            CHECK(between.count(e) == 1);
        }
    }
    CHECK(creases > 100);
}

TEST_CASE("blocks of groups hold one family each", "[grid]") {
    const mesh::Cage wing = test::sample_cage("wing/wing_cage.obj");
    const BlockLayout layout = grid::make_layout(wing);
    std::set<std::string> families, names;
    for (const grid::Block& block : layout.blocks) {
        families.insert(block.family);
        CHECK(names.insert(block.name).second);
    }
    CHECK(families == std::set<std::string>{"upper", "lower", "nose", "te", "tip", "root"});
}

/// Sides of all blocks along each edge, in the edge's direction.
std::vector<std::vector<std::vector<geom::Vec3>>> points_along_edges(const Plan& plan) {
    std::vector<std::vector<std::vector<geom::Vec3>>> result(plan.edges.size());
    const grid::BlockEvaluator evaluator(plan);
    for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
        const BlockPoints p = evaluator.evaluate(int(b));
        for (int side = 0; side < 4; ++side) {
            int begin = 0;
            for (const grid::BlockEdgeUse& use : plan.layout.blocks[b].sides[std::size_t(side)]) {
                const int cells = plan.edges[std::size_t(use.edge)].cells();
                std::vector<geom::Vec3> points;
                for (int n = begin; n <= begin + cells; ++n) {
                    points.push_back(side == 0   ? p.at(n, 0)
                                     : side == 1 ? p.at(p.ni - 1, n)
                                     : side == 2 ? p.at(p.ni - 1 - n, p.nj - 1)
                                                 : p.at(0, p.nj - 1 - n));
                }
                if (use.reversed) std::reverse(points.begin(), points.end());
                result[std::size_t(use.edge)].push_back(std::move(points));
                begin += cells;
            }
        }
    }
    return result;
}

TEST_CASE("points of both sides of a block edge are the same to the last bit", "[grid]") {
    for (const mesh::Cage& cage : cages()) {
        for (const bool join : {false, true}) {
            BlockLayout layout = grid::make_layout(cage);
            if (join) layout = grid::join_all(layout);
            const Plan plan = grid::make_plan(
                layout, {.cells = 7, .law = grid::Law::Tanh, .first_at_creases_mm = 0.05});
            for (const auto& uses : points_along_edges(plan)) {
                for (const auto& points : uses) {
                    REQUIRE(points.size() == uses[0].size());
                    for (std::size_t k = 0; k < points.size(); ++k) {
                        CHECK((points[k].array() == uses[0][k].array()).all());
                    }
                }
            }
        }
    }
}

TEST_CASE("grid points lie on the limit surface at their parameters", "[grid][oracle]") {
    for (const mesh::Cage& cage : cages()) {
        const BlockLayout layout = grid::join_all(grid::make_layout(cage));
        const Plan plan = grid::make_plan(layout, {.cells = 9, .law = grid::Law::Cosine});
        const grid::BlockEvaluator evaluator(plan);
        const mesh::Topology& t = *layout.cage.topology;
        const subd::LimitEvaluator limit(layout.cage.topology);
        const double size = geom::bounding_box(cage.points).diagonal();
        for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
            const grid::Block& block = layout.blocks[b];
            const BlockPoints p = evaluator.evaluate(int(b));
            for (int i = 0; i < p.ni; i += 2) {
                for (int j = 0; j < p.nj; j += 3) {
                    const Eigen::Vector2d at = evaluator.parameters(int(b), i, j);
                    const int column = std::clamp(int(at.x()), 0, block.columns - 1);
                    const int row = std::clamp(int(at.y()), 0, block.rows - 1);
                    const double u = std::clamp(at.x() - column, 0.0, 1.0);
                    const double v = std::clamp(at.y() - row, 0.0, 1.0);
                    const mesh::CornerId c = block.cell(column, row);
                    const mesh::FaceId f = t.face(c);
                    // A quarter turn for each corner that the cell starts at.
                    const int turns = c.value - t.corners(f)[0].value;
                    const Eigen::Vector2d in_face(turns == 0   ? u
                                                  : turns == 1 ? 1 - v
                                                  : turns == 2 ? 1 - u
                                                               : v,
                                                  turns == 0   ? v
                                                  : turns == 1 ? u
                                                  : turns == 2 ? 1 - v
                                                               : 1 - u);
                    const auto exact =
                        limit.position(layout.cage.points, {f, in_face.x(), in_face.y()});
                    // Rounding; near block edges parameters are found to 1e-13 of the edge.
                    CHECK((p.at(i, j) - exact).norm() < 1e-11 * size);
                }
            }
        }
    }
}

mesh::TopologyInput with_corners() {
    mesh::TopologyInput tags;
    tags.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    return tags;
}

TEST_CASE("uniform points are at equal arc lengths", "[grid][oracle]") {
    const Plan flat =
        grid::make_plan(grid::make_layout(test::grid(3, 4, with_corners())), {.size_mm = 0.1});
    for (const auto& edge : flat.edges) {
        const double n = edge.cells();
        const geom::Vec3 a = edge.points.row(0), b = edge.points.row(edge.points.rows() - 1);
        CHECK(edge.length_mm == Approx((b - a).norm()).epsilon(1e-10));
        CHECK(n == Approx(std::ceil(edge.length_mm / 0.1 - 1e-9)));
        for (Eigen::Index k = 0; k + 1 < edge.points.rows(); ++k) {
            CHECK((edge.points.row(k + 1) - edge.points.row(k)).norm() ==
                  Approx(edge.length_mm / n).epsilon(1e-9));
        }
    }
}

/// Length along an edge up to each point, by chords so fine that they are arcs.
double length_between(const Plan& plan, int edge, double from, double to) {
    const subd::LimitEvaluator limit(plan.layout.cage.topology);
    const mesh::Topology& t = *plan.layout.cage.topology;
    const auto& run = plan.layout.edges[std::size_t(edge)].run;
    const auto at = [&](double s) {
        const auto k = std::min(std::size_t(s), run.size() - 1);
        const double f = s - double(k);
        const mesh::FaceId face = t.face(run[k]);
        const int side = run[k].value - t.corners(face)[0].value;
        return limit.position(plan.layout.cage.points, {face,
                                                        side == 0   ? f
                                                        : side == 1 ? 1.0
                                                        : side == 2 ? 1 - f
                                                                    : 0.0,
                                                        side == 0   ? 0.0
                                                        : side == 1 ? f
                                                        : side == 2 ? 1.0
                                                                    : 1 - f});
    };
    double sum = 0.0;
    constexpr int steps = 4000;
    geom::Vec3 before = at(from);
    for (int k = 1; k <= steps; ++k) {
        const geom::Vec3 here = at(from + (to - from) * k / steps);
        sum += (here - before).norm();
        before = here;
    }
    return sum;
}

TEST_CASE("first cells off creases have the size asked for", "[grid]") {
    const mesh::Cage wing = test::sample_cage("wing/wing_cage.obj");
    const BlockLayout layout = grid::make_layout(wing);
    const double first = 0.7;
    for (const auto measure : {grid::Measure::ArcLength, grid::Measure::Curvature}) {
        const Plan plan = grid::make_plan(layout, {.size_mm = 40.0,
                                                   .law = grid::Law::Tanh,
                                                   .measure = measure,
                                                   .first_at_creases_mm = first});
        int checked = 0;
        for (const grid::Block& block : layout.blocks) {
            for (std::size_t side = 0; side < 4; ++side) {
                const grid::BlockEdgeUse use = block.sides[side][0];
                const auto& edge = plan.edges[std::size_t(use.edge)];
                if (edge.length_mm < 10 * first || edge.cells() < 4) continue;
                for (const bool at_begin : {true, false}) {
                    const std::size_t other = at_begin ? (side + 3) % 4 : (side + 1) % 4;
                    if (!grid::is_crease(layout, block.sides[other][0].edge)) continue;
                    const bool low = at_begin != use.reversed;
                    const auto& s = edge.parameters;
                    const double length =
                        low ? length_between(plan, use.edge, s[0], s[1])
                            : length_between(plan, use.edge, s[s.size() - 2], s.back());
                    CHECK(length == Approx(first).epsilon(1e-4));
                    ++checked;
                }
            }
        }
        CHECK(checked > 10);
    }
}

TEST_CASE("a rule holds at corresponding ends of all edges that lines connect", "[grid]") {
    const BlockLayout layout = grid::make_layout(test::sample_cage("wing/wing_cage.obj"));
    for (const bool connected : {false, true}) {
        // The size is met on every edge of the class that has room for it, at one end only.
        const Plan plan = grid::make_plan(layout, {.cells = 24,
                                                   .rules = {{.edge = 0,
                                                              .cells = 30,
                                                              .law = grid::Law::Tanh,
                                                              .first_mm = 2.0,
                                                              .connected = connected}}});
        int sized = 0, same_count = 0;
        for (const auto& edge : plan.edges) {
            const auto last = edge.points.rows() - 1;
            const double first = (edge.points.row(1) - edge.points.row(0)).norm();
            const double other = (edge.points.row(last) - edge.points.row(last - 1)).norm();
            same_count += edge.cells() == 30 ? 1 : 0;
            if (edge.cells() == 30 && std::abs(std::min(first, other) - 2.0) < 0.02) {
                ++sized;
                CHECK(std::max(first, other) > 3.0);
            }
        }
        CHECK(same_count > 1);
        CHECK(sized == (connected ? same_count : 1));
        // Lines on both sides of a block border have the same points.
        for (const auto& uses : points_along_edges(plan)) {
            for (const auto& points : uses) CHECK(points == uses[0]);
        }
    }
}

TEST_CASE("joining blocks keeps points and outward normals", "[grid]") {
    for (const mesh::Cage& cage : {test::cube(2.0), test::torus(8, 6, 3.0, 1.0)}) {
        const BlockLayout layout = grid::make_layout(cage);
        // The first block and a neighbour of it.
        const auto places = grid::edge_places(layout);
        const auto& users = places[std::size_t(layout.blocks[0].sides[1][0].edge)];
        const int other = users[0].block == 0 ? users[1].block : users[0].block;
        const BlockLayout joined = grid::join(layout, 0, other);
        check_layout(joined);
        CHECK(joined.blocks.size() == layout.blocks.size() - 1);
        CHECK(joined.blocks[0].cells.size() ==
              layout.blocks[0].cells.size() + layout.blocks[std::size_t(other)].cells.size());
        const Plan plan = grid::make_plan(joined, {.cells = 8});
        const grid::BlockEvaluator evaluator(plan);
        for (std::size_t b = 0; b < joined.blocks.size(); ++b) {
            const BlockPoints p = evaluator.evaluate(int(b));
            for (int i = 0; i + 1 < p.ni; ++i) {
                for (int j = 0; j + 1 < p.nj; ++j) {
                    const geom::Vec3 n =
                        (p.at(i + 1, j + 1) - p.at(i, j)).cross(p.at(i, j + 1) - p.at(i + 1, j));
                    geom::Vec3 out = p.at(i, j);
                    if (cage.topology->vertex_count() > 8) {
                        const double r = std::hypot(out.x(), out.y());
                        out -= 3.0 * geom::Vec3(out.x() / r, out.y() / r, 0.0);
                    }
                    CHECK(n.dot(out) > 0.0);
                }
            }
        }
    }
    // Opposite faces of a cube share nothing.
    const BlockLayout cube = grid::make_layout(test::cube(2.0));
    int refused = 0;
    for (int b = 1; b < 6; ++b) {
        try {
            grid::join(cube, 0, b);
        } catch (const base::InvalidArgument&) {
            ++refused;
        }
    }
    CHECK(refused == 1);
    CHECK_THROWS_AS(grid::join(cube, 0, 0), base::InvalidArgument);
}

TEST_CASE("refinement by an error function ends below the limit", "[grid]") {
    const Plan coarse =
        grid::make_plan(grid::make_layout(test::sample_cage("cages/genus2.obj")), {.cells = 2});
    const auto chord = [](const geom::Vec3& a, const geom::Vec3& b, const geom::Vec3& middle) {
        return (middle - 0.5 * (a + b)).norm();
    };
    const double limit = 2e-3 * geom::bounding_box(coarse.layout.cage.points).diagonal();
    const Plan fine = grid::refined(coarse, chord, limit);
    CHECK(fine.cell_count() > coarse.cell_count());
    // Refining again changes nothing.
    CHECK(grid::refined(fine, chord, limit).cell_count() == fine.cell_count());
    // Edges still match.
    for (const auto& uses : points_along_edges(fine)) {
        for (const auto& points : uses) CHECK(points.size() == uses[0].size());
    }
    CHECK_THROWS_AS(grid::refined(coarse, chord, 0.0), base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
