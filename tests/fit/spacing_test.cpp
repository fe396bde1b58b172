#include "fit/loop/spacing.h"

#include "support/cages.h"

#include <patchwright/fit/fit.h>
#include <patchwright/mesh/chords.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>

using namespace patchwright;
using geom::Vec3;

namespace {

/// A cage with the chords of some edges halved, at the middles of these, and its edges' halvings.
struct Halved {
    mesh::Cage cage;
    std::vector<int> halvings;
};

Halved halved(const mesh::Cage& cage, const std::vector<mesh::EdgeId>& edges) {
    const mesh::Chords chords = mesh::find_chords(*cage.topology);
    std::vector<char> chosen(std::size_t(chords.count), 0);
    for (const mesh::EdgeId e : edges) chosen[std::size_t(chords.of_edge[e.index()])] = 1;
    const mesh::ChordSplit fine = mesh::split_chords(*cage.topology, chords, chosen);
    Halved result{{.topology = fine.topology, .points = {}}, {}};
    result.cage.points.resize(fine.topology->vertex_count(), 3);
    for (const mesh::VertexId v : fine.topology->vertices()) {
        const auto& at = fine.vertices[v.index()];
        const auto c = cage.topology->corners(at.face);
        const auto point = [&](int i) {
            return cage.points.row(cage.topology->vertex(c[i]).value);
        };
        result.cage.points.row(v.value) = (1 - at.u) * (1 - at.v) * point(0) +
                                          at.u * (1 - at.v) * point(1) + at.u * at.v * point(2) +
                                          (1 - at.u) * at.v * point(3);
    }
    result.halvings.assign(std::size_t(fine.topology->edge_count()), 0);
    for (const mesh::FaceId f : fine.topology->faces())
        for (int i = 0; i < 4; ++i)
            result.halvings[fine.topology->edge(fine.topology->corners(f)[i]).index()] =
                fine.cuts[fine.parents[f.index()].index()] >> (i % 2) & 1;
    return result;
}

/// Different x coordinates of a grid's vertices, ascending.
std::vector<double> lines_across_x(const mesh::Cage& cage) {
    std::vector<double> lines(cage.points.col(0).begin(), cage.points.col(0).end());
    std::sort(lines.begin(), lines.end());
    lines.erase(
        std::unique(lines.begin(), lines.end(), [](double a, double b) { return b - a < 1e-9; }),
        lines.end());
    return lines;
}

double largest_ratio(const std::vector<double>& lines) {
    double most = 1.0;
    for (std::size_t i = 2; i < lines.size(); ++i) {
        const double a = lines[i - 1] - lines[i - 2], b = lines[i] - lines[i - 1];
        most = std::max({most, a / b, b / a});
    }
    return most;
}

/// Across x at column i of a grid with nv rows of faces.
mesh::EdgeId edge_of_column(const mesh::Cage& cage, int i, int nv) {
    return cage.topology->edge(cage.topology->corners(mesh::FaceId{i * nv})[0]);
}

Vec3 radial(const Vec3& point) { return Vec3(point.x(), point.y(), 0).normalized(); }

/// Of radius 1 around z.
class Cylinder final : public geom::ReferenceSurface {
  public:
    geom::Box3 bounds() const override { return {Vec3(-1, -1, -1), Vec3(1, 1, 1)}; }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        const Vec3 p = radial(q) + Vec3(0, 0, q.z());
        return {p, radial(q), (q - p).norm(), 0};
    }
};

/// An open tube of radius 1 around z with nu quads around and nv along; numbered as test::grid.
mesh::Cage tube(int nu, int nv) {
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces;
    const auto at = [&](int i, int j) { return (i % nu) * (nv + 1) + j; };
    for (int i = 0; i < nu; ++i) {
        const double a = 2.0 * M_PI * i / nu;
        for (int j = 0; j <= nv; ++j) points.emplace_back(std::cos(a), std::sin(a), 0.3 * j);
        for (int j = 0; j < nv; ++j)
            faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    return test::make_cage(points, faces);
}

}  // namespace

TEST_CASE("a halved strip's jump spreads over its neighbours", "[fit][oracle]") {
    const mesh::Cage coarse =
        test::grid(10, 3, {.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
    auto [cage, halvings] = halved(coarse, {edge_of_column(coarse, 4, 3)});
    REQUIRE(largest_ratio(lines_across_x(cage)) == Approx(2.0));
    const geom::Points given = cage.points;
    fit::grade_spacing(cage, halvings);
    const double moved = (cage.points - given).rowwise().norm().maxCoeff();
    const auto lines = lines_across_x(cage);
    REQUIRE(lines.size() == 12);  // lines stay straight
    CHECK(largest_ratio(lines) < 1.3 * 1.05);
    CHECK(lines.front() == 0.0);
    CHECK(lines.back() == 10.0);
    CHECK(cage.points.col(2).isZero());
    // Some of what the strip gained is given to its neighbours.
    CHECK(moved > 0.05);
    CHECK(moved < 0.5);
    CHECK(lines[5] - lines[4] < 0.7);
}

TEST_CASE("spacing that was there before a split is kept", "[fit]") {
    mesh::Cage coarse = test::grid(10, 3, {.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
    coarse.points.col(0) = coarse.points.col(0).unaryExpr([](double x) { return std::exp2(x); });
    auto [cage, halvings] = halved(coarse, {});
    const geom::Points given = cage.points;
    fit::grade_spacing(cage, halvings);
    CHECK((cage.points - given).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("strips halved more than once stay narrow, pins and creases where they are", "[fit]") {
    mesh::TopologyInput tags{.boundary_rule = mesh::BoundaryRule::EdgeAndCorner};
    for (int j = 0; j < 3; ++j) tags.creases.push_back({2 * 4 + j, 2 * 4 + j + 1, 10.0});
    tags.pins = {7 * 4 + 1};
    const mesh::Cage coarse = test::grid(10, 3, tags);
    auto [cage, halvings] = halved(coarse, {edge_of_column(coarse, 4, 3)});
    const geom::Points given = cage.points;
    auto twice = halvings;
    for (int& count : twice) count *= 2;
    fit::grade_spacing(cage, twice);
    CHECK(cage.points == given);
    fit::grade_spacing(cage, halvings);
    for (int j = 1; j < 3; ++j)  // the crease crosses the lines along x
        CHECK((cage.points.row(2 * 4 + j) - given.row(2 * 4 + j)).norm() == 0.0);
    CHECK((cage.points.row(7 * 4 + 1) - given.row(7 * 4 + 1)).norm() == 0.0);
    CHECK((cage.points.row(7 * 4 + 2) - given.row(7 * 4 + 2)).norm() > 0.01);
    cage.points = given;
    fit::grade_spacing(cage, halvings, {mesh::VertexId{7 * 4 + 2}});
    CHECK((cage.points.row(7 * 4 + 2) - given.row(7 * 4 + 2)).norm() == 0.0);
}

TEST_CASE("a fit on graded strips has better normals than on halved ones", "[fit][oracle]") {
    // A cylinder is as curved everywhere: as many lines, evenly spaced, follow it best.
    const Cylinder cylinder;
    const mesh::Cage coarse = tube(24, 2);
    const auto normals_rms = [&](bool graded) {
        auto [cage, halvings] = halved(coarse, {edge_of_column(coarse, 3, 2)});
        if (graded) fit::grade_spacing(cage, halvings);
        const mesh::Cage fitted =
            fit::fit(cage, cylinder, {.tolerance_mm = 1e-9, .max_levels = 0}).cage;
        const subd::LimitEvaluator evaluator(fitted.topology);
        double squares = 0.0;
        for (const mesh::FaceId f : fitted.topology->faces()) {
            for (const double u : {0.1, 0.5, 0.8}) {
                const auto point = evaluator.evaluate(fitted.points, {f, u, 0.5}, 1);
                squares += point.normal.cross(radial(point.position)).squaredNorm();
            }
        }
        return std::sqrt(squares / (3.0 * fitted.topology->face_count()));
    };
    CHECK(normals_rms(true) < 0.7 * normals_rms(false));
}
