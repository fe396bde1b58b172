#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/morph.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

using namespace patchwright;
using fit::PointTransfer;
using geom::Points;
using geom::Vec3;

namespace {

/// Of the largest value that goes in.
constexpr double rounding = 1e-12;

double largest(const Points& points) { return points.cwiseAbs().maxCoeff(); }

/// Seeded, in the box from `low` to `high`.
Points scattered(int count, unsigned seed, const Vec3& low, const Vec3& high) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) points(i, k) = low[k] + (high[k] - low[k]) * share(random);
    return points;
}

/// A wing's spar, away from the origin, and a cage around it.
struct Structure {
    Points points = scattered(150, 1, Vec3(900, -50, 100), Vec3(1100, 1950, 130));
    mesh::Cage cage = test::random_cage(3);
    Structure() {
        const geom::Box3 box = geom::bounding_box(cage.points);
        cage.points.rowwise() -= box.centre().transpose();
        for (int k = 0; k < 3; ++k)
            cage.points.col(k) *=
                std::array{300.0, 2200.0, 60.0}[std::size_t(k)] / (box.max[k] - box.min[k]);
        cage.points.rowwise() += Eigen::RowVector3d(1000, 950, 115);
    }
};

Points affine(const Points& points, const Eigen::Matrix3d& map, const Vec3& shift) {
    return (points * map.transpose()).rowwise() + shift.transpose();
}

/// Places on all faces of a cage.
struct Places {
    std::vector<std::int32_t> faces, sectors;
    std::vector<double> uv;
    explicit Places(const mesh::Topology& topology) {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> share(0.0, 1.0);
        for (const mesh::FaceId f : topology.faces()) {
            faces.push_back(f.value);
            sectors.push_back(topology.size(f) == 4 ? 0 : topology.size(f) - 1);
            uv.push_back(share(random));
            uv.push_back(share(random));
        }
        uv[0] = uv[1] = 0.0;  // a vertex
    }
    [[nodiscard]] subd::Locations all() const { return {faces, uv, sectors}; }
};

/// A beam bent to an arc of this radius: lengths along z = 0 stay.
Points bent(const Points& points, double radius) {
    Points result = points;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double angle = points(i, 0) / radius, arm = radius - points(i, 2);
        result(i, 0) = arm * std::sin(angle);
        result(i, 2) = radius - arm * std::cos(angle);
    }
    return result;
}

/// A box of 10 x 1 x 1 with points at distances of 1 / n.
Points beam(int n) {
    Points points((10 * n + 1) * (n + 1) * (n + 1), 3);
    Eigen::Index row = 0;
    for (int i = 0; i <= 10 * n; ++i)
        for (int j = 0; j <= n; ++j)
            for (int k = 0; k <= n; ++k)
                points.row(row++) =
                    Eigen::RowVector3d(i, j, k) / n - Eigen::RowVector3d(0, 0.5, 0.5);
    return points;
}

}  // namespace

TEST_CASE("affine maps and rigid motions of the structure are those of the cage",
          "[fit][morph][oracle]") {
    const Structure s;
    const PointTransfer transfer(s.points, s.cage.points);
    CHECK(transfer.rows() == s.cage.points.rows());
    CHECK(transfer.columns() == 150);
    const auto check = [&](const Eigen::Matrix3d& map, const Vec3& shift) {
        const Points displaced = affine(s.points, map, shift) - s.points;
        const Points expected = affine(s.cage.points, map, shift);
        const mesh::Cage moved = fit::morph(s.cage, transfer, displaced);
        CHECK(largest(moved.points - expected) < rounding * largest(expected));
        CHECK(moved.topology == s.cage.topology);
    };
    check(Eigen::Matrix3d::Identity(), Vec3(1e3, -20, 3));
    check(Eigen::AngleAxisd(2.0, Vec3(1, 2, -1).normalized()).toRotationMatrix(), Vec3(5, 6, 7));
    check((Eigen::Matrix3d() << 1.2, 0.3, 0, -0.1, 0.8, 0.5, 0.2, 0, 1.1).finished(),
          Vec3(-300, 0, 40));
    const Points still = Points::Zero(150, 3);
    CHECK(fit::morph(s.cage, transfer, still).points == s.cage.points);
}

TEST_CASE("the field has the given values at the structural points", "[fit][morph][oracle]") {
    const Structure s;
    const Points values = scattered(150, 2, Vec3::Constant(-1), Vec3::Constant(1));
    CHECK(largest(PointTransfer(s.points, s.points).apply(values) - values) < rounding);
    // Four points: nothing but a linear polynomial.
    Points four(4, 3), middle(1, 3);
    four << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    middle << 0.25, 0.25, 0.25;
    const Points mean = PointTransfer(four, middle).apply(values.topRows(4));
    CHECK(largest(mean - values.topRows(4).colwise().mean()) < rounding);
}

TEST_CASE("a transfer does not depend on unit, place or threads", "[fit][morph]") {
    const Structure s;
    const Points values = scattered(150, 2, Vec3::Constant(-1), Vec3::Constant(1));
    const Points field = PointTransfer(s.points, s.cage.points).apply(values);
    const Points far = (s.points * 1e-3).rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Points far_cage = (s.cage.points * 1e-3).rowwise() + Eigen::RowVector3d(1, 2, 3);
    CHECK(largest(PointTransfer(far, far_cage).apply(values) - field) < 1e-9);
    base::set_thread_count(1);
    CHECK(PointTransfer(s.points, s.cage.points).apply(values) == field);
    base::set_thread_count(0);
}

TEST_CASE("a bent beam comes near its closed form as points become denser",
          "[fit][morph][oracle]") {
    // The arc is a third of a circle.
    const double radius = 10.0 / (2.0 * M_PI / 3.0);
    const Points whole = scattered(300, 4, Vec3(0, -0.5, -0.5), Vec3(10, 0.5, 0.5));
    const Points inside = scattered(300, 4, Vec3(1, -0.2, -0.2), Vec3(9, 0.2, 0.2));
    std::vector<double> errors, inner_errors;
    for (const int n : {2, 4, 6}) {
        const Points structure = beam(n);
        const Points displacements = bent(structure, radius) - structure;
        const auto error = [&](const Points& at) {
            const Points field = PointTransfer(structure, at).apply(displacements);
            return largest(at + field - bent(at, radius));
        };
        errors.push_back(error(whole));
        inner_errors.push_back(error(inside));
    }
    CAPTURE(errors, inner_errors);
    // Second order at the border of what is interpolated, as of natural splines; fourth inside.
    CHECK(errors[0] < 0.05);
    CHECK(errors[1] < errors[0] / 3.0);
    CHECK(errors[2] < errors[1] / 2.0);
    CHECK(inner_errors[1] < inner_errors[0] / 12.0);
    CHECK(inner_errors[2] < inner_errors[1] / 3.0);
}

TEST_CASE("the transpose is the transpose, virtual work is the same on both sides",
          "[fit][morph][oracle]") {
    const Structure s;
    const PointTransfer transfer(s.points, s.cage.points);
    const Places places(*s.cage.topology);
    const auto count = int(places.faces.size());
    const Points forces = scattered(count, 5, Vec3(-1, -1, 0), Vec3(1, 1, 3));
    const Points nodal =
        transfer.apply_transposed(fit::control_point_forces(s.cage.topology, places.all(), forces));
    REQUIRE(nodal.rows() == 150);
    const subd::LimitEvaluator surface(s.cage.topology);
    for (const unsigned seed : {6U, 7U, 8U}) {
        const Points motion = scattered(150, seed, Vec3::Constant(-1), Vec3::Constant(1));
        const Points velocities = surface.evaluate(transfer.apply(motion), places.all());
        const double on_surface = velocities.cwiseProduct(forces).sum();
        const double on_structure = motion.cwiseProduct(nodal).sum();
        const double size = velocities.cwiseProduct(forces).cwiseAbs().sum();
        CHECK(std::abs(on_surface - on_structure) < rounding * size);
    }
}

TEST_CASE("the sum of forces and their moment about any point stay", "[fit][morph][oracle]") {
    const Structure s;
    const PointTransfer transfer(s.points, s.cage.points);
    const Places places(*s.cage.topology);
    const Points forces = scattered(int(places.faces.size()), 5, Vec3(-1, -1, 0), Vec3(1, 1, 3));
    const Points nodal =
        transfer.apply_transposed(fit::control_point_forces(s.cage.topology, places.all(), forces));
    const subd::LimitEvaluator surface(s.cage.topology);
    const Points motion = scattered(150, 9, Vec3::Constant(-100), Vec3::Constant(100));
    const auto displaced = fit::morph(s.cage, transfer, motion).points;
    using Shape = std::tuple<Points, Points>;  // structure, cage
    for (const auto& [structure, cage] :
         {Shape(s.points, s.cage.points), Shape(s.points + motion, displaced)}) {
        const Points at = surface.evaluate(cage, places.all());
        for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(1000, 950, 115), Vec3(-2e3, 5e3, 700)}) {
            const fit::Resultant given = fit::resultant(at, forces, centre);
            const fit::Resultant carried = fit::resultant(structure, nodal, centre);
            const double force = forces.rowwise().norm().sum();
            const double arm = (at.rowwise() - centre.transpose()).rowwise().norm().maxCoeff();
            CHECK((given.force - carried.force).norm() < rounding * force);
            CHECK((given.moment - carried.moment).norm() < rounding * force * arm);
        }
    }
}

TEST_CASE("points that determine no field are refused", "[fit][morph]") {
    const Points cage = scattered(5, 1, Vec3(0, 0, 0), Vec3(1, 1, 1));
    Points points = scattered(40, 1, Vec3(0, 0, 0), Vec3(100, 100, 100));
    const auto refused = [&](const Points& from, const char* text) {
        const auto line = [](int i) { return "line " + std::to_string(i + 2); };
        CHECK_THROWS_WITH(PointTransfer(from, cage, line), Catch::Contains(text));
        CHECK_THROWS_AS(PointTransfer(from, cage, line), base::InputError);
    };
    Points same = points;
    same.row(30) = same.row(7);
    same.row(31) = same.row(9);
    refused(same, "line 9 and line 32 are in one place; keep one of them");
    refused(points.topRows(3), "3 points: at least four are needed");
    refused(points.topRows(1).replicate(9, 1), "all points are in one place");
    refused(Points::Zero(fit::max_transfer_points + 1, 3), "10001 points");
    Points flat = points;
    flat.col(2) = 0.3 * flat.col(0) - flat.col(1);
    refused(flat, "all points are in one plane");
    flat.col(1) = 0.1 * flat.col(0);
    flat.col(2).setConstant(5.0);
    refused(flat, "all points are in one line");
    flat = points;
    flat.col(2) *= 1e-3;
    CHECK_NOTHROW(PointTransfer(flat, cage));
    CHECK_THROWS_AS(PointTransfer(points, cage).apply(points.topRows(2)), base::InvalidArgument);
    CHECK_THROWS_AS(PointTransfer(points, cage).apply_transposed(points), base::InvalidArgument);
}

TEST_CASE("extrapolation is told", "[fit][morph]") {
    const Points points = scattered(200, 1, Vec3(0, 0, 0), Vec3(100, 100, 1));
    const auto at = [&](double x, double y, double z) {
        Points place(1, 3);
        place << x, y, z;
        return PointTransfer(points, place).extrapolation();
    };
    CHECK(at(50, 50, 0.5) < 1.1);
    CHECK(at(100, 100, 1) < 4.0);
    // The root mean square extent of evenly scattered points is 1 / sqrt(12) of their width.
    CHECK(at(50, 50, 50.5) == Approx(50.0 * std::sqrt(12.0)).epsilon(0.1));
}

TEST_CASE("tags that displaced points cannot follow are refused", "[fit][morph]") {
    const Points points = scattered(20, 1, Vec3::Constant(-1), Vec3::Constant(1));
    const Points still = Points::Zero(20, 3);
    mesh::TopologyInput tags;
    tags.sectors.push_back({.vertex = 0, .face = 0, .normal = {-1, -1, -1}});
    const mesh::Cage given = test::cube(2.0);
    mesh::TopologyInput angle;
    for (const int v : {1, 2}) angle.creases.push_back({0, v, mesh::infinite_sharpness});
    angle.sectors.push_back({.vertex = 0, .face = 0, .angle = 1.0});
    tags.creases = angle.creases;
    const mesh::Cage normal = test::cube(2.0, tags), open = test::cube(2.0, angle);
    CHECK_THROWS_WITH(fit::morph(normal, PointTransfer(points, normal.points), still),
                      Catch::Contains("vertex 0") && Catch::Contains("normal"));
    CHECK(fit::morph(open, PointTransfer(points, open.points), still).points == open.points);
    const Places places(*open.topology);
    CHECK_THROWS_WITH(fit::control_point_forces(open.topology, places.all(), Points::Zero(6, 3)),
                      Catch::Contains("vertex 0") && Catch::Contains("forces"));
    CHECK_THROWS_AS(fit::morph(given, PointTransfer(points, points), still), base::InvalidArgument);
}
