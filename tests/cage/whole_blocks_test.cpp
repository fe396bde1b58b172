// Blocks with pieces of their own, lines without edges, and quads along coordinates.
#include "cage/field/whole_blocks.h"

#include "cage/blocks/folded_quads.h"
#include "cage/field/grid_vertices.h"
#include "cage/field/map_grid.h"
#include "field_layout.h"
#include "support/triangle_shapes.h"

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright {
namespace {

using cage::Vec2;
using geom::Vec3;

cage::Poll poll;  // never stops

std::size_t at(int i) { return std::size_t(i); }

/// A rectangle from (x0, 0) to (x1, height) of triangles, border first, from its first corner on.
cage::FlatPiece rectangle(double x0, double x1, double height, int m, int n) {
    std::vector<std::pair<int, int>> order;
    for (int i = 0; i < m; ++i) order.emplace_back(i, 0);
    for (int j = 0; j < n; ++j) order.emplace_back(m, j);
    for (int i = m; i > 0; --i) order.emplace_back(i, n);
    for (int j = n; j > 0; --j) order.emplace_back(0, j);
    const std::size_t border = order.size();
    for (int j = 1; j < n; ++j)
        for (int i = 1; i < m; ++i) order.emplace_back(i, j);
    std::map<std::pair<int, int>, int> number;
    std::vector<Vec3> points;
    std::vector<Vec2> flat;
    for (const auto& [i, j] : order) {
        number[{i, j}] = int(points.size());
        points.emplace_back(x0 + (x1 - x0) * i / m, height * j / n, 0.0);
        if (points.size() <= border) flat.emplace_back(double(i) / m, double(j) / n);
    }
    std::vector<std::array<int, 3>> triangles;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < m; ++i) {
            const std::array q{number[{i, j}], number[{i + 1, j}], number[{i + 1, j + 1}],
                               number[{i, j + 1}]};
            // No triangle with three corners on the border.
            const bool turn = (i == 0 && j == 0) || (i + 1 == m && j + 1 == n);
            triangles.push_back({q[0], q[1], turn ? q[2] : q[3]});
            triangles.push_back({turn ? q[0] : q[1], q[2], q[3]});
        }
    return {points, triangles, flat};
}

double area_of(const cage::FlatPiece& piece) {
    double sum = 0.0;
    for (const auto& t : piece.triangles()) {
        const Vec3 &a = piece.points()[at(t[0])], &b = piece.points()[at(t[1])],
                   &c = piece.points()[at(t[2])];
        sum += 0.5 * (b - a).cross(c - a).norm();
    }
    return sum;
}

/// Every block has a piece to itself, whose border points are those of its arcs in their order.
void check_whole(const cage::QuadLayout& layout) {
    REQUIRE(layout.pieces.size() == layout.blocks.size());
    for (const cage::LayoutArc& arc : layout.arcs) {
        CHECK(arc.piece == -1);
        CHECK(arc.points.front() == layout.nodes[at(arc.start)].point);
        CHECK(arc.points.back() == layout.nodes[at(arc.end)].point);
    }
    for (const cage::LayoutBlock& block : layout.blocks) {
        REQUIRE(block.first_point.has_value());
        std::vector<Vec3> border;
        for (std::size_t s = 0; s < 4; ++s) {
            REQUIRE(!block.sides[s].empty());
            CHECK(block.flat[s].size() == block.sides[s].size());
            for (const cage::ArcUse& use : block.sides[s]) {
                std::vector<Vec3> points = layout.arcs[at(use.arc)].points;
                if (use.reversed) std::reverse(points.begin(), points.end());
                border.insert(border.end(), points.begin(), points.end() - 1);
            }
        }
        const auto& points = layout.pieces[at(block.piece)].points();
        for (std::size_t k = 0; k < border.size(); ++k)
            CHECK(points[(k + at(*block.first_point)) % border.size()] == border[k]);
    }
}

TEST_CASE("a straight line cuts a piece in two", "[field][oracle]") {
    const cage::FlatPiece square = rectangle(0.0, 1.0, 1.0, 10, 10);
    cage::CutDisc disc(square, 40);
    // From (0.3, 0) to (0.8, 1), which no line of the triangles follows.
    const std::vector<int> path = disc.draw(3, 22);
    REQUIRE(path.size() > 10);
    for (const int v : path) {
        const Vec2& p = disc.flat(v);
        CHECK(std::abs(p.x() - (0.3 + 0.5 * p.y())) < 1e-12);
    }
    std::vector<int> right(path.rbegin(), path.rend()), left(path.begin(), path.end());
    right.pop_back();
    for (int v = 3; v < 22; ++v) right.push_back(v);
    left.pop_back();
    for (int v = 22; v < 43; ++v) left.push_back(v % 40);
    // Where vertices were moved onto the line on the flat piece, they stay where they are in space:
    // at most by the twentieth part of a side of 0.1.
    const auto on_circle = [](std::size_t count) {
        std::vector<Vec2> border;
        for (std::size_t k = 0; k < count; ++k)
            border.emplace_back(std::cos(2.0 * M_PI * double(k) / double(count)),
                                std::sin(2.0 * M_PI * double(k) / double(count)));
        return border;
    };
    std::rotate(right.begin(), right.end() - 19, right.end());
    const cage::FlatPiece one = disc.piece(right, on_circle(right.size())),
                          two = disc.piece(left, on_circle(left.size()));
    CHECK(area_of(one) + area_of(two) == Approx(1.0).epsilon(1e-12));
    CHECK(area_of(one) == Approx(0.45).margin(0.005));
    SECTION("not across another line") { CHECK_THROWS_AS(disc.draw(30, 15), cage::LayoutRefused); }
}

TEST_CASE("vertices of a cut piece go where they are asked to be", "[field]") {
    cage::CutDisc disc(rectangle(0.0, 1.0, 1.0, 4, 4), 16);
    for (const Vec2& p : {Vec2(0.4, 0.55), Vec2(0.5, 0.5), Vec2(0.75, 0.26), Vec2(0.01, 0.3)}) {
        const int v = disc.add_vertex(p);
        CHECK((disc.flat(v) - p).norm() < 1e-12);
        CHECK((disc.point(v) - Vec3(p.x(), p.y(), 0.0)).norm() < 0.05 * 0.25 * 2.0);
    }
    CHECK_THROWS_AS(disc.add_vertex({1.5, 0.5}), cage::LayoutRefused);
}

/// A prism along z over a triangle with right angles at the origin.
geom::TriangleMesh triangular_prism(double side, double height) {
    geom::TriangleMesh mesh;
    mesh.points.resize(6, 3);
    mesh.points << 0, 0, 0, side, 0, 0, 0, side, 0, 0, 0, height, side, 0, height, 0, side, height;
    mesh.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3},
                      {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

TEST_CASE("pieces with three sides are cut into their blocks", "[field][oracle]") {
    test::FieldLayout prism(triangular_prism(10.0, 10.0));
    const auto shared = std::count_if(prism.layout.blocks.begin(), prism.layout.blocks.end(),
                                      [](const cage::LayoutBlock& b) { return !b.first_point; });
    REQUIRE(shared >= 3);  // of a lid: the field is free to end its lines elsewhere
    cage::cut_shared_pieces(prism.layout);
    check_whole(prism.layout);
    double area = 0.0;
    for (const cage::FlatPiece& piece : prism.layout.pieces) area += area_of(piece);
    // Two lids and three walls.
    CHECK(area == Approx(100.0 + 200.0 + 100.0 * std::sqrt(2.0)).epsilon(1e-9));

    const cage::MetricSizes sizes{.tolerance_rel = 1e-3, .largest_rel = 0.15};
    const cage::SizeMetric metric(prism.layout, prism.reference, sizes, poll);
    cage::set_wanted(prism.layout, metric, prism.reference, sizes, poll);
    cage::Divisions divisions = cage::divisions_apart(prism.layout, poll);
    cage::part_at_insertions(prism.layout, divisions);
    const cage::SizeMetric metric_of_parts(prism.layout, prism.reference, sizes, poll);
    const cage::Blocks quads =
        cage::map_grid(prism.layout, divisions, metric_of_parts, prism.reference, poll).blocks;
    CHECK(quads.corners.size() == 6);
    // Far from folded, where lids have corners of 45 degrees.
    for (std::size_t f = 0; f < quads.faces.size(); ++f) CHECK(cage::least_sine(quads, f) > 0.2);
}

TEST_CASE("a block with an insertion becomes three", "[field]") {
    test::FieldLayout box(test::triangle_box(10, 10, 10));
    cage::QuadLayout& layout = box.layout;
    REQUIRE(layout.blocks.size() == 6);
    const int side = GENERATE(0, 1, 2, 3);
    cage::Divisions divisions;
    divisions.edges.assign(layout.arcs.size(), 7);
    divisions.insertions.resize(layout.blocks.size());
    // Sides of 5, 4, 3 and 2 edges: two strips go around the corner between the first two.
    divisions.insertions[0] = {side, 2};
    constexpr std::array edges{5, 4, 3, 2};
    for (int k = 0; k < 4; ++k) {
        const cage::BlockSide& arcs = layout.blocks[0].sides[at((side + k) % 4)];
        REQUIRE(arcs.size() == 1);
        divisions.edges[at(arcs[0].arc)] = edges[at(k)];
    }
    const int before = int(layout.nodes.size());
    cage::part_at_insertions(layout, divisions);
    check_whole(layout);
    CHECK(layout.blocks.size() == 8);
    CHECK(int(layout.nodes.size()) == before + 3);
    double area = 0.0;
    for (const cage::FlatPiece& piece : layout.pieces) area += area_of(piece);
    CHECK(area == Approx(600.0).epsilon(1e-9));
    // Two by two, three by two and two by three.
    std::vector<int> products;
    for (const std::size_t b : {0, 6, 7}) {
        CHECK(divisions.insertions[b].count == 0);
        std::array<int, 4> sum{};
        for (std::size_t s = 0; s < 4; ++s)
            for (const cage::ArcUse& use : layout.blocks[b].sides[s])
                sum[s] += divisions.edges[at(use.arc)];
        CHECK(sum[0] == sum[2]);
        CHECK(sum[1] == sum[3]);
        products.push_back(sum[0] * sum[1]);
    }
    std::sort(products.begin(), products.end());
    CHECK(products == std::vector<int>{4, 6, 6});
}

/// A plate of blocks side by side between lines at these places.
struct Plate {
    Plate(const std::vector<double>& x, double height) : reference(triangles(x.back(), height)) {
        const int count = int(x.size());
        for (int row = 0; row < 2; ++row)
            for (int i = 0; i < count; ++i) {
                cage::LayoutNode node;
                node.point = Vec3(x[at(i)], height * row, 0.0);
                node.corner = i == 0 || i + 1 == count;
                if (!node.corner) node.curve = curve_at(node.point);
                layout.nodes.push_back(node);
            }
        for (int i = 0; i + 1 < count; ++i) add_arc(i, i + 1, steps);
        for (int i = 0; i + 1 < count; ++i) add_arc(count + i, count + i + 1, steps);
        for (int i = 0; i < count; ++i) add_arc(i, count + i, steps);
        for (int i = 0; i + 1 < count; ++i) {
            cage::LayoutBlock block;
            block.sides = {cage::BlockSide{{i, false}},
                           {{2 * (count - 1) + i + 1, false}},
                           {{count - 1 + i, true}},
                           {{2 * (count - 1) + i, true}}};
            block.flat = {std::vector{Vec2(0, 0)}, {Vec2(1, 0)}, {Vec2(1, 1)}, {Vec2(0, 1)}};
            block.piece = i;
            block.first_point = 0;
            layout.blocks.push_back(block);
            layout.pieces.push_back(rectangle(x[at(i)], x[at(i + 1)], height, steps, steps));
        }
    }

    static constexpr int steps = 8;

    static geom::TriangleMesh triangles(double width, double height) {
        geom::TriangleMesh mesh;
        mesh.points.resize(4, 3);
        mesh.points << 0, 0, 0, width, 0, 0, width, height, 0, 0, height, 0;
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.part.assign(2, -1);
        return mesh;
    }

    [[nodiscard]] int curve_at(const Vec3& p) const {
        int best = -1;
        double least = 1e-6;
        for (int c = 0; c < int(reference.features().curves.size()); ++c) {
            const double distance = reference.nearest_on_curve(c, p).distance;
            if (distance >= least) continue;
            least = distance;
            best = c;
        }
        return best;
    }

    void add_arc(int start, int end, int count) {
        cage::LayoutArc arc;
        arc.start = start;
        arc.end = end;
        const Vec3 &a = layout.nodes[at(start)].point, &b = layout.nodes[at(end)].point;
        for (int k = 0; k <= count; ++k) arc.points.emplace_back(a + (b - a) * (double(k) / count));
        arc.curve = curve_at(0.5 * (a + b));
        layout.arcs.push_back(arc);
    }

    geom::MeshReference reference;
    cage::QuadLayout layout;
};

TEST_CASE("lines side by side become one", "[field][oracle]") {
    // Three lines within a fiftieth of an edge: with an edge in each arc there would be quads fifty
    // times as long as wide.
    Plate plate({0.0, 4.0, 4.01, 4.02, 10.0}, 5.0);
    const cage::MetricSizes sizes{.tolerance_rel = 1e-3, .largest_rel = 0.1};
    const cage::SizeMetric metric(plate.layout, plate.reference, sizes, poll);
    cage::set_wanted(plate.layout, metric, plate.reference, sizes, poll);
    const cage::Divisions divisions = cage::divisions_apart(plate.layout, poll);
    CHECK(cage::least_apart(plate.layout, divisions).empty());
    for (const int narrow : {1, 2, 5, 6}) CHECK(divisions.edges[at(narrow)] == 0);
    const cage::Blocks quads =
        cage::map_grid(plate.layout, divisions, metric, plate.reference, poll).blocks;
    // Edges of 1.1 mm are wanted: nine by four or five.
    CHECK(quads.faces.size() >= 32);
    CHECK(quads.faces.size() <= 45);
    double area = 0.0;
    for (std::size_t f = 0; f < quads.faces.size(); ++f) {
        CHECK(cage::least_sine(quads, f) > 0.99);
        area += cage::quad_area(quads, f).norm();
    }
    CHECK(area == Approx(50.0).epsilon(1e-9));
    for (const Vec3& p : quads.points) CHECK(std::abs(p.z()) < 1e-9);
}

TEST_CASE("what must stay apart gets edges", "[field]") {
    Plate plate({0.0, 4.0, 10.0}, 5.0);
    cage::QuadLayout& layout = plate.layout;
    cage::Divisions divisions;
    divisions.insertions.resize(layout.blocks.size());
    const auto least = [&](std::vector<int> edges) {
        divisions.edges = std::move(edges);
        return cage::least_apart(layout, divisions);
    };
    // Arcs: bottom left and right, top left and right, then upright from left to right.
    CHECK(least({2, 3, 2, 3, 2, 2, 2}).empty());
    // A line may fall upon the border beside it ...
    CHECK(least({0, 3, 0, 3, 2, 2, 2}).empty());
    // ... but the borders not upon each other.
    layout.arcs[0].wanted = layout.arcs[2].wanted = 0.3;
    layout.arcs[1].wanted = layout.arcs[3].wanted = 0.4;
    const auto raised = least({0, 0, 0, 0, 2, 2, 2});
    REQUIRE(!raised.empty());
    for (const auto& [arc, edges] : raised) {
        CHECK((arc == 1 || arc == 3));
        CHECK(edges == 1);
    }
    // Nor may the lower border fall upon the upper one.
    CHECK(!least({2, 3, 2, 3, 0, 0, 0}).empty());
    // An insertion needs an edge on both of the sides beyond it.
    divisions.insertions[0] = {0, 2};
    const auto with_insertion = least({2, 3, 0, 3, 2, 4, 4});
    CHECK(with_insertion.contains(2));
}

}  // namespace
}  // namespace patchwright
