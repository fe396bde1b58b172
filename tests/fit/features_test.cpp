#include "fit/match/feature_match.h"
#include "plate.h"
#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;
using test::Plate;

namespace {

mesh::Cage sharp_cube(double edge) {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] < face[(i + 1) % 4]) {
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
            }
        }
    }
    return test::cube(edge, tags);
}

/// A cube whose upper rim is sharp along x and fades along y: smooth there, on one side in two
/// curves that meet without a corner. All other edges are smooth, too.
class FadedRim final : public test::Box {
  public:
    FadedRim() {
        for (geom::FeatureCurve& c : features_.curves)
            if (!is_upper(c) || c.start.x() == c.end.x()) c.kind = geom::FeatureKind::Smooth;
        for (std::size_t i = 0; i < features_.curves.size(); ++i) {
            geom::FeatureCurve& c = features_.curves[i];
            if (!is_upper(c) || c.start.x() < 1.0 || c.end.x() < 1.0) continue;
            geom::FeatureCurve rest = c;
            c.end = rest.start = 0.5 * (c.start + c.end);
            c.end_corner = rest.start_corner = -1;
            c.length = rest.length = 0.5 * c.length;
            features_.curves.push_back(rest);
            break;
        }
    }
    static bool is_upper(const geom::FeatureCurve& c) { return c.start.z() > 0 && c.end.z() > 0; }
};

/// A cube with sharp edges, and a smooth one across its top from the middle of one to that of
/// another, where there are no corners.
class Divided final : public test::Box {
  public:
    Divided() {
        geom::FeatureCurve across;
        across.kind = geom::FeatureKind::Smooth;
        across.length = 2.0;
        across.greatest_angle_rad = 0.2;
        across.start = Vec3(0, -1, 1);
        across.end = Vec3(0, 1, 1);
        features_.curves.push_back(across);
    }
};

/// A flat square with a sharp edge from the middle of one side to a point inside, where it ends.
class Cut : public test::StraightEdged {
  public:
    Cut() {
        const std::array<Vec3, 6> at{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0),
                                     Vec3(-1, 1, 0),  Vec3(-1, 0, 0), end()};
        for (const Vec3& p : at) features_.corners.push_back({p, geom::CornerKind::Junction, {}});
        features_.corners.back().kind = geom::CornerKind::End;
        for (const auto& [from, to] : {std::pair(0, 1), {1, 2}, {2, 3}, {3, 4}, {4, 0}, {4, 5}}) {
            geom::FeatureCurve curve;
            curve.kind = to == 5 ? geom::FeatureKind::Sharp : geom::FeatureKind::Free;
            curve.start_corner = from;
            curve.end_corner = to;
            curve.start = at[std::size_t(from)];
            curve.end = at[std::size_t(to)];
            curve.length = (curve.end - curve.start).norm();
            for (const int corner : {from, to})
                features_.corners[std::size_t(corner)].curves.push_back(
                    int(features_.curves.size()));
            features_.curves.push_back(curve);
        }
    }
    static Vec3 end() { return {0.15, 0.0, 0.0}; }
    geom::Box3 bounds() const override { return {Vec3(-1, -1, 0), Vec3(1, 1, 0)}; }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        const Vec3 p(std::clamp(q.x(), -1.0, 1.0), std::clamp(q.y(), -1.0, 1.0), 0.0);
        return {p, Vec3::UnitZ(), (q - p).norm(), 0};
    }
};

/// The same, and a smooth edge goes on from there to the other side.
class CutThatFades final : public Cut {
  public:
    CutThatFades() {
        geom::FeatureCurve rest;
        rest.kind = geom::FeatureKind::Smooth;
        rest.greatest_angle_rad = 0.2;
        rest.start_corner = int(features_.corners.size()) - 1;
        rest.start = end();
        rest.end = Vec3(1, 0, 0);
        rest.length = (rest.end - rest.start).norm();
        features_.curves.push_back(rest);
    }
};

/// Two flat squares side by side that touch along x = 0 but are not connected: their corners
/// there are in the same place.
class Slit final : public test::StraightEdged {
  public:
    Slit() {
        for (int side = 0; side < 2; ++side) {
            for (int k = 0; k < 4; ++k) {
                const int next = 4 * side + (k + 1) % 4;
                geom::FeatureCurve edge;
                edge.kind = geom::FeatureKind::Free;
                edge.length = 2.0;
                edge.start_corner = 4 * side + k;
                edge.end_corner = next;
                edge.start = corner(edge.start_corner);
                edge.end = corner(next);
                features_.curves.push_back(edge);
                features_.corners.push_back({edge.start,
                                             geom::CornerKind::Junction,
                                             {4 * side + k, 4 * side + (k + 3) % 4}});
            }
        }
    }
    static Vec3 corner(int number) {
        const int k = number % 4;
        return {(k == 1 || k == 2 ? 2.0 : 0.0) - (number < 4 ? 2.0 : 0.0), k < 2 ? -1.0 : 1.0, 0.0};
    }
    geom::Box3 bounds() const override { return {Vec3(-2, -1, 0), Vec3(2, 1, 0)}; }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        const Vec3 p(std::clamp(q.x(), -2.0, 2.0), std::clamp(q.y(), -1.0, 1.0), 0.0);
        return {p, Vec3::UnitZ(), (q - p).norm(), 0};
    }
};

/// The upper half of the unit disc: curve 0 is its diameter, curve 1 its arc.
class HalfDisc final : public geom::ReferenceSurface {
  public:
    HalfDisc() {
        for (const double length : {2.0, M_PI}) {
            geom::FeatureCurve curve;
            curve.kind = geom::FeatureKind::Free;
            curve.length = length;
            curve.start_corner = 0;
            curve.end_corner = 1;
            curve.start = Vec3(1, 0, 0);
            curve.end = Vec3(-1, 0, 0);
            features_.curves.push_back(curve);
        }
        for (const double x : {1.0, -1.0})
            features_.corners.push_back({Vec3(x, 0, 0), geom::CornerKind::Junction, {0, 1}});
    }
    geom::Box3 bounds() const override { return {Vec3(-1, 0, 0), Vec3(1, 1, 0)}; }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        const Vec3 p(q.x(), q.y(), 0.0);
        return {p, Vec3::UnitZ(), std::abs(q.z()), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int curve, const Vec3& q, const std::optional<geom::ArcRange>& within) const override {
        const double s = curve == 0 ? 1.0 - q.x() : std::atan2(std::max(q.y(), 0.0), q.x());
        const double length = features_.curves[std::size_t(curve)].length;
        geom::FeaturePoint hit = point_on_curve(
            curve, std::clamp(s, within ? within->from : 0.0, within ? within->to : length));
        hit.distance = (hit.point - q).norm();
        return hit;
    }
    geom::FeaturePoint point_on_curve(int curve, double s) const override {
        if (curve == 0) return {Vec3(1.0 - s, 0, 0), 0.0, 0, s, Vec3(-1, 0, 0)};
        return {Vec3(std::cos(s), std::sin(s), 0), 0.0, 1, s, Vec3(-std::sin(s), std::cos(s), 0)};
    }

  private:
    geom::Features features_;
};

fit::FeatureMatch match(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    const auto curves = fit::curve_sites(*cage.topology);
    const subd::LimitOperator limit(*cage.topology, fit::side_sets(4), curves.sites);
    geom::Points samples;
    limit.apply(cage.points, samples);
    return fit::match_features(cage, curves, samples, 4, reference, 0.2, [] {});
}

double length(const fit::FeaturePath& path) {
    double sum = 0.0;
    for (const auto& piece : path) sum += piece.range.to - piece.range.from;
    return sum;
}

mesh::Cage square_grid(mesh::TopologyInput tags) {
    mesh::Cage cage = test::grid(4, 4, std::move(tags));
    cage.points = (cage.points.array() - 2.0) * 0.45;
    cage.points.col(2).setConstant(0.05);
    return cage;
}

}  // namespace

TEST_CASE("corners keep their order where the cage is off by more than a part is thick",
          "[fit][features]") {
    const Vec3 half(1.0, 1.0, 0.01);
    mesh::Cage cage = sharp_cube(2.0);
    cage.points.col(2) = 0.012 * cage.points.col(2).array() + 0.03;
    const auto result = fit::fit(cage, test::Box(half), {.tolerance_mm = 1e-9});
    CHECK(result.within_tolerance);
    CHECK(result.levels.back().chains_on_features == 12);
    for (int v = 0; v < 8; ++v) {
        const Vec3 corner =
            half.cwiseProduct(Vec3(2 * (v & 1) - 1, 2 * (v >> 1 & 1) - 1, 2 * (v >> 2) - 1));
        CHECK((result.cage.points.row(v).transpose() - corner).norm() == 0.0);
    }
}

TEST_CASE("a boundary with corners takes one curve between two corners", "[fit][features]") {
    const mesh::Cage cage = square_grid({.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
    const auto found = match(cage, Plate());
    REQUIRE(found.paths.size() == 4);
    CHECK(found.corners.size() == 4);
    for (const auto& path : found.paths) {
        CHECK(path.size() == 1);
        CHECK(length(path) == 2.0);
    }
}

TEST_CASE("corners in one place belong to the curves along their own chains", "[fit][features]") {
    // Either half of the slit, in a position that the order of its vertices does not tell.
    for (const double x : {-1.0, 1.0}) {
        mesh::Cage cage = square_grid({.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
        cage.points.col(0) = cage.points.col(0).array() / 0.9 + x;
        cage.points.col(2).setZero();
        const auto found = match(cage, Slit());
        REQUIRE(found.paths.size() == 4);
        for (const auto& path : found.paths) {
            REQUIRE(path.size() == 1);
            CHECK((path[0].curve < 4) == (x < 0.0));
        }
    }
}

TEST_CASE("a boundary without corners, or with one, goes all the way round", "[fit][features]") {
    const auto closed = match(square_grid({}), Plate());
    REQUIRE(closed.paths.size() == 1);
    CHECK(length(closed.paths[0]) == Approx(8.0));
    mesh::TopologyInput one;
    one.corners.push_back({0, mesh::infinite_sharpness});
    const auto loop = match(square_grid(one), Plate());
    REQUIRE(loop.paths.size() == 1);
    CHECK(length(loop.paths[0]) == Approx(8.0));
    REQUIRE(loop.corners.size() == 1);
    CHECK(loop.corners[0].point == Vec3(-1, -1, Plate::thickness));
}

TEST_CASE("chains between the same corners take a curve each", "[fit][features]") {
    // So flat that both of its chains are nearer to the diameter than to the arc.
    mesh::TopologyInput ends;
    ends.corners = {{0, mesh::infinite_sharpness}, {8, mesh::infinite_sharpness}};
    mesh::Cage cage = test::grid(4, 1, ends);
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v) {
        const double x = 0.5 * cage.points(v, 0) - 1.0, y = cage.points(v, 1);
        cage.points.row(v) << (1.0 - 0.2 * y) * x, 0.25 * y, 0.0;
    }
    const auto found = match(cage, HalfDisc());
    REQUIRE(found.paths.size() == 2);
    REQUIRE(found.paths[0].size() == 1);
    REQUIRE(found.paths[1].size() == 1);
    CHECK(found.paths[0][0].curve + found.paths[1][0].curve == 1);
}

TEST_CASE("a chain follows its own way though a shorter one joins its ends", "[fit][features]") {
    // Three sides of the rim from corner to corner; the fourth is the shorter way.
    mesh::TopologyInput two;
    two.corners = {{0, mesh::infinite_sharpness}, {4, mesh::infinite_sharpness}};
    const auto found = match(square_grid(two), Plate());
    REQUIRE(found.paths.size() == 2);
    CHECK(std::max(length(found.paths[0]), length(found.paths[1])) == Approx(6.0));
    CHECK(std::min(length(found.paths[0]), length(found.paths[1])) == Approx(2.0));
}

TEST_CASE("sharp edges that are far from every feature are fitted like the surface",
          "[fit][features]") {
    mesh::TopologyInput tags;
    for (int j = 0; j < 4; ++j) {
        tags.creases.push_back({10 + j, 11 + j, mesh::infinite_sharpness});
    }
    const auto found = match(square_grid(tags), Plate());
    int without = 0;
    for (const auto& path : found.paths) without += path.empty() ? 1 : 0;
    CHECK(without == 1);
}

TEST_CASE("creases that meet within a sharp edge go to where a smooth one begins",
          "[fit][features]") {
    // Corner i is at (i & 1, i >> 1 & 1, i >> 2); the two points across are off along the edges.
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i)
        points.emplace_back(2 * (i & 1) - 1, 2 * (i >> 1 & 1) - 1, 2 * (i >> 2) - 1);
    points.emplace_back(0.08, -1.01, 1.0);
    points.emplace_back(-0.06, 1.0, 1.02);
    const std::vector<std::vector<int>> faces{{0, 2, 3, 1},    {4, 8, 9, 6},    {8, 5, 7, 9},
                                              {0, 1, 5, 8, 4}, {2, 6, 9, 7, 3}, {0, 4, 6, 2},
                                              {1, 3, 7, 5}};
    mesh::TopologyInput tags;
    for (const auto& [a, b] : {std::pair(0, 1),
                               {1, 3},
                               {3, 2},
                               {2, 0},
                               {4, 8},
                               {8, 5},
                               {5, 7},
                               {7, 9},
                               {9, 6},
                               {6, 4},
                               {0, 4},
                               {1, 5},
                               {2, 6},
                               {3, 7},
                               {8, 9}})
        tags.creases.push_back({a, b, mesh::infinite_sharpness});
    const Divided reference;
    const auto found = match(test::make_cage(points, faces, tags), reference);
    const Vec3 start(0, -1, 1), end(0, 1, 1);
    int at_ends = 0;
    for (const auto& place : found.corners) {
        if (place.vertex.value == 8) CHECK((place.point - start).norm() == 0.0);
        if (place.vertex.value == 9) CHECK((place.point - end).norm() == 0.0);
        at_ends += place.vertex.value >= 8 ? 1 : 0;
    }
    CHECK(at_ends == 2);
    double sum = 0.0;
    const int across = int(reference.features().curves.size()) - 1;
    int along_it = 0;
    for (const auto& path : found.paths) {
        sum += length(path);
        along_it += path.size() == 1 && path[0].curve == across ? 1 : 0;
    }
    CHECK(along_it == 1);
    CHECK(sum == Approx(26.0));  // twelve edges and the one across, each once
}

TEST_CASE("a crease goes on along smooth edges where sharp ones fade", "[fit][features]") {
    mesh::TopologyInput rim;
    for (const auto& [a, b] : {std::pair(4, 5), {5, 7}, {7, 6}, {6, 4}})
        rim.creases.push_back({a, b, mesh::infinite_sharpness});
    const FadedRim reference;
    // The limit curve of four points is a circle of radius 0.94 within the rim.
    mesh::Cage cage = test::cube(2.0, rim);
    const auto found = match(cage, reference);
    REQUIRE(found.paths.size() == 1);
    CHECK(found.paths[0].size() >= 5);  // one more where it begins within a curve
    CHECK(length(found.paths[0]) == Approx(8.0));
    for (const auto& piece : found.paths[0])
        CHECK(FadedRim::is_upper(reference.features().curves[std::size_t(piece.curve)]));
}

TEST_CASE("a crease that ends within the surface ends where its curve does", "[fit][features]") {
    mesh::TopologyInput tags;
    for (const int corner : {0, 4, 20, 24})
        tags.corners.push_back({corner, mesh::infinite_sharpness});
    tags.creases = {{2, 7, mesh::infinite_sharpness}, {7, 12, mesh::infinite_sharpness}};
    mesh::Cage cage = test::grid(4, 4, tags);
    cage.points = (cage.points.array() - 2.0) * 0.5;
    cage.points.col(2).setZero();
    // The end is off, and so is what lies around it, which moves its limit point.
    cage.points.row(12) = Eigen::RowVector3d(0.05, 0.1, 0.02);
    cage.points.row(17) += Eigen::RowVector3d(0.1, 0.15, 0.0);
    const double tolerance = 1e-3;
    const auto result = fit::fit(cage, Cut(), {.tolerance_mm = tolerance});
    CHECK(result.within_tolerance);
    const std::vector<subd::Site> sites{
        fit::vertex_site(*result.cage.topology, mesh::VertexId{12})};
    geom::Points limit;
    subd::LimitOperator(*result.cage.topology, fit::corner_sets(), sites)
        .apply(result.cage.points, limit);
    CHECK((limit.row(0).transpose() - Cut::end()).norm() < tolerance);
}

TEST_CASE("the end of a fitted crease is where its limit point is", "[fit][features]") {
    mesh::TopologyInput tags;
    tags.creases = {{2, 7, mesh::infinite_sharpness}, {7, 12, mesh::infinite_sharpness}};
    mesh::Cage cage = test::grid(4, 4, tags);
    cage.points = (cage.points.array() - 2.0) * 0.5;
    cage.points.col(2).setZero();
    // Long edges of the crease beside shorter ones carry the control point of its end beyond it.
    cage.points(12, 0) = 0.7;
    for (const int v : {6, 7, 8, 11, 13, 16, 17, 18}) cage.points(v, 0) -= 0.29;
    cage.points.rowwise() +=
        (Cut::end() - subd::limit_position(cage, mesh::VertexId{12})).transpose();
    const auto found = match(cage, CutThatFades());
    REQUIRE(found.darts.size() == 1);
    CHECK((found.darts[0].point - Cut::end()).norm() < 1e-12);
}
