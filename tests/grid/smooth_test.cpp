#include "grid/sample_cage.h"
#include "grid/smooth_cells.h"
#include "grid/surface_walk.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/layers.h>
#include <patchwright/grid/quality.h>
#include <patchwright/grid/smooth.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace patchwright {
namespace {

using geom::Vec3;
using grid::Plan;

Plan plan_of(const mesh::Cage& cage, int cells) {
    return grid::make_plan(grid::make_layout(cage), {.cells = cells});
}

Vec3 row(const geom::Points& points, Eigen::Index r) { return points.row(r).transpose(); }

/// A rectangle of nu x nv unit faces with corners.
mesh::Cage rectangle(int nu, int nv) {
    mesh::TopologyInput tags;
    for (const int v : {0, nv, nu * (nv + 1), nu * (nv + 1) + nv})
        tags.corners.push_back({v, mesh::infinite_sharpness});
    return test::grid(nu, nv, tags);
}

/// A square of 8 x 8 faces whose inner vertices are moved at random in its plane.
mesh::Cage shaken_square() {
    mesh::Cage cage = rectangle(8, 8);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> shake(-0.45, 0.45);
    for (const mesh::VertexId v : cage.topology->vertices())
        if (!cage.topology->is_boundary(v))
            cage.points.row(v.value) += Eigen::RowVector3d(shake(random), shake(random), 0.0);
    return cage;
}

}  // namespace

TEST_CASE("walks end where they were sent, over faces' sides and extraordinary vertices",
          "[grid]") {
    const mesh::Cage cage = subd::refine(test::cube(2.0), 2);
    subd::RingTable table;
    grid::SurfaceWalk walk(table, cage);
    const subd::LimitEvaluator limit(cage.topology);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    int crossed = 0;
    for (int k = 0; k < 500; ++k) {
        // Every tenth from a vertex, eight of which have three faces.
        subd::Location from{mesh::FaceId{int(any(random) * cage.topology->face_count())},
                            any(random), any(random)};
        if (k % 10 == 0) from.u = from.v = 0.0;
        const subd::LimitPoint start = limit.evaluate(cage.points, from, 1);
        CHECK((walk.at(from).point - start.position).norm() < 1e-12);
        const double angle = 2.0 * M_PI * any(random), length = 0.15 * any(random);
        const Vec3 a = start.normal.unitOrthogonal();
        const Vec3 by = length * (std::cos(angle) * a + std::sin(angle) * start.normal.cross(a));
        const subd::Location to = walk.moved(from, by);
        crossed += to.face != from.face ? 1 : 0;
        // Newton's steps leave 1e-3 of the way; a tangent leaves the surface by half its square
        // times the curvature, which is below 2 all over this one.
        const Vec3 way = limit.position(cage.points, to) - start.position;
        CHECK((way - by).norm() < 2e-3 * length + 1.0 * length * length + 1e-12);
    }
    CHECK(crossed > 100);
}

TEST_CASE("points of sharp edges walk along them", "[grid][oracle]") {
    mesh::TopologyInput tags;
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}})
        tags.creases.push_back({a, b, mesh::infinite_sharpness});
    const mesh::Cage cage = test::cube(2.0, tags);
    subd::RingTable table;
    grid::SurfaceWalk walk(table, cage);
    grid::LinePlace at{cage.topology->corners(mesh::FaceId{0})[0], 0.5};
    // The four sharp edges are one closed curve in the plane z = -1.
    Vec3 ahead = 0.1 * walk.direction(at).normalized();
    Vec3 here = walk.at(grid::location_of(*cage.topology, at)).point;
    double turned = 0.0;
    for (int k = 0; k < 60; ++k) {
        at = walk.moved(at, ahead);
        REQUIRE(grid::is_feature(*cage.topology, at.edge));
        const Vec3 next = walk.at(grid::location_of(*cage.topology, at)).point;
        CHECK(next.z() == Approx(-1.0));
        CHECK((next - here).norm() == Approx(0.1).epsilon(0.05));
        turned += std::atan2(here.cross(next).z(), here.head<2>().dot(next.head<2>()));
        const Vec3 way = walk.direction(at).normalized();
        ahead = way.dot(next - here) > 0.0 ? Vec3(0.1 * way) : Vec3(-0.1 * way);
        here = next;
    }
    CHECK(std::abs(turned) > 2.0 * M_PI);

    // Other points end there.
    const subd::Location middle{mesh::FaceId{0}, 0.5, 0.5};
    for (const Vec3& over : {Vec3(1.5, 0.3, 0), Vec3(-1.5, 0.1, 0), Vec3(0.2, 1.5, 0)}) {
        const subd::Location end = walk.moved(middle, over);
        CHECK(end.face == middle.face);
        CHECK(std::min({end.u, end.v, 1.0 - end.u, 1.0 - end.v}) == 0.0);
    }
}

TEST_CASE("derivatives of the energy are those of its differences", "[grid][oracle]") {
    const Plan plan = plan_of(test::sample_cage("wing_fuselage/cage.obj"), 4);
    const grid::FrontMesh mesh(plan);
    grid::SmoothCells cells(plan, mesh, [](std::int32_t, std::int32_t) { return false; });
    geom::Points points = mesh.surface();
    cells.measure_normals(points);
    std::vector<grid::SmoothCells::Basis> bases;
    for (Eigen::Index p = 0; p < points.rows(); ++p) {
        grid::SmoothCells::Basis basis;
        basis.col(0) = row(cells.point_normals(), p).unitOrthogonal();
        basis.col(1) = row(cells.point_normals(), p).cross(basis.col(0));
        bases.push_back(basis);
    }
    const auto energy = [&](std::size_t c) {
        std::vector<double> all;
        cells.energies(points, all);
        return all[c];
    };
    for (std::size_t c = 3; c < cells.cells().size(); c += 47) {
        const auto derivatives = cells.derivatives(c, points, bases);
        for (std::size_t k = 0; k < 8; ++k) {
            const auto p = Eigen::Index(cells.cells()[c].points[k / 2]);
            const Vec3 step = bases[std::size_t(p)].col(Eigen::Index(k % 2));
            const Vec3 here = row(points, p);
            // Central differences: 1e-4 mm of cells some 10 mm long.
            points.row(p) = (here + 1e-4 * step).transpose();
            const double above = energy(c);
            points.row(p) = (here - 1e-4 * step).transpose();
            const double below = energy(c);
            points.row(p) = here.transpose();
            CHECK(derivatives.first[Eigen::Index(k)] ==
                  Approx((above - below) / 2e-4).margin(1e-6).epsilon(1e-5));
        }
        // What stands for the second ones has no negative curvature.
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> eigen(derivatives.second);
        CHECK(eigen.eigenvalues().minCoeff() > -1e-9 * eigen.eigenvalues().maxCoeff());
    }
}

TEST_CASE("a grid whose points are all fixed stays", "[grid]") {
    const Plan plan = plan_of(rectangle(2, 2), 1);
    const Plan moved = grid::smoothed(plan);
    for (std::size_t e = 0; e < plan.edges.size(); ++e)
        CHECK((moved.edges[e].points - plan.edges[e].points).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("a grid that is as it is to be stays", "[grid][oracle]") {
    const Plan plan = plan_of(rectangle(3, 2), 6);
    const Plan moved = grid::smoothed(plan);
    for (std::size_t e = 0; e < plan.edges.size(); ++e)
        CHECK((moved.edges[e].points - plan.edges[e].points).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a shaken square's cells become squares again", "[grid][oracle]") {
    const Plan plan = plan_of(shaken_square(), 24);
    const auto before = grid::measure_quality(grid::SurfaceGrid(plan));
    const Plan moved = grid::smoothed(plan);
    const auto after = grid::measure_quality(grid::SurfaceGrid(moved));
    CHECK(before.min_angle.worst < 60.0 * M_PI / 180.0);
    CHECK(after.min_angle.worst > 85.0 * M_PI / 180.0);
}

TEST_CASE("angles around extraordinary vertices become alike", "[grid]") {
    const mesh::Cage cage = test::sample_cage("wing_fuselage/smooth.obj");
    const Plan plan = grid::make_plan(grid::make_layout(cage), {.size_mm = 30.0});
    const auto before = grid::measure_quality(grid::SurfaceGrid(plan));
    const Plan moved = grid::smoothed(plan);
    const auto after = grid::measure_quality(grid::SurfaceGrid(moved));
    REQUIRE(after.extraordinary.size() == 4);
    for (const grid::VertexQuality& v : after.extraordinary) {
        const double even = 2.0 * M_PI / v.cells, near = 15.0 * M_PI / 180.0;
        CHECK(v.min_angle_rad > even - near);
        CHECK(v.max_angle_rad < even + near);
    }
    CHECK(before.min_angle.worst < 35.0 * M_PI / 180.0);
    CHECK(after.min_angle.worst > 45.0 * M_PI / 180.0);
    CHECK(after.min_angle.mean > before.min_angle.mean);
    CHECK(after.folded == 0);

    // Every point has a place on the cage and lies there; those of common sides are one.
    const subd::LimitEvaluator limit(cage.topology);
    const grid::BlockEvaluator evaluator(moved);
    grid::BlockPlaces places;
    for (int b = 0; b < int(moved.layout.blocks.size()); ++b) {
        const grid::BlockPoints points = evaluator.evaluate(b);
        evaluator.places(b, places);
        for (int n = 0; n < int(points.count()); n += 7) {
            const auto k = std::size_t(n);
            const Vec3 p = limit.position(
                cage.points, {mesh::FaceId{places.faces[k]}, places.u[k], places.v[k]});
            CHECK((points.at(n % points.ni, n / points.ni) - p).norm() < 1e-9);
        }
        int begin = 0;
        for (const grid::BlockEdgeUse& use : moved.layout.blocks[std::size_t(b)].sides[0]) {
            const grid::EdgePoints& edge = moved.edges[std::size_t(use.edge)];
            for (int k = 0; k <= edge.cells(); ++k) {
                const Vec3 p = row(edge.points, use.reversed ? edge.cells() - k : k);
                CHECK(points.at(begin + k, 0) == p);
            }
            begin += edge.cells();
        }
    }
}

TEST_CASE("borders and sharp edges keep their points, corners theirs", "[grid]") {
    const Plan plan = plan_of(test::sample_cage("wing_tip/cage.obj"), 12);
    const Plan moved = grid::smoothed(plan);
    const mesh::Topology& t = *plan.layout.cage.topology;
    int on_features = 0;
    for (std::size_t b = 0; b < moved.moved.size(); ++b) {
        int begin = 0;
        for (const grid::BlockEdgeUse& use : plan.layout.blocks[b].sides[0]) {
            const auto& run = plan.layout.edges[std::size_t(use.edge)].run;
            const int cells = plan.edges[std::size_t(use.edge)].cells();
            if (grid::is_feature(t, run.front())) {
                for (int k = 1; k < cells; ++k) {
                    // On a side of its face that is a feature.
                    const subd::Location& at = moved.moved[b][std::size_t(begin + k)];
                    const auto corners = t.corners(at.face);
                    CHECK(((at.v == 0.0 && grid::is_feature(t, corners[0])) ||
                           (at.u == 1.0 && grid::is_feature(t, corners[1])) ||
                           (at.v == 1.0 && grid::is_feature(t, corners[2])) ||
                           (at.u == 0.0 && grid::is_feature(t, corners[3]))));
                    ++on_features;
                }
            }
            begin += cells;
        }
    }
    CHECK(on_features > 20);

    const auto before = grid::measure_quality(grid::SurfaceGrid(plan)).extraordinary;
    const auto after = grid::measure_quality(grid::SurfaceGrid(moved)).extraordinary;
    REQUIRE(after.size() == before.size());
    int stayed = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
        mesh::CornerId c = t.corner(before[k].vertex);
        bool on_crease = false;
        for (int n = 0; n < before[k].cells; ++n, c = t.rotate(c))
            on_crease = on_crease || grid::is_feature(t, c);
        CHECK(((after[k].at - before[k].at).norm() < 1e-9) == on_crease);
        stayed += on_crease ? 1 : 0;
    }
    CHECK(stayed > 0);
    CHECK(stayed < int(before.size()));
}

TEST_CASE("points that coincide stay and keep no others back", "[grid]") {
    // Two neighbours inside a shaken square in one place: a block edge of no length is refused, but
    // lines inside may have none.
    mesh::Cage cage = rectangle(4, 4);
    cage.points.row(12) += Eigen::RowVector3d(0.4, 0.3, 0.0);
    for (const int v : {6, 7, 11}) cage.points.row(v) = cage.points.row(12);
    const Plan plan = plan_of(cage, 8);
    const auto before = grid::measure_quality(grid::SurfaceGrid(plan));
    const Plan moved = grid::smoothed(plan);
    const auto after = grid::measure_quality(grid::SurfaceGrid(moved));
    for (const grid::EdgePoints& edge : moved.edges) CHECK(edge.points.allFinite());
    CHECK(after.min_angle.mean > before.min_angle.mean);
}

TEST_CASE("the same bits with any number of threads", "[grid]") {
    const Plan plan = plan_of(test::sample_cage("wing_fuselage/smooth.obj"), 9);
    base::set_thread_count(1);
    const Plan one = grid::smoothed(plan);
    base::set_thread_count(0);
    const Plan all = grid::smoothed(plan);
    for (std::size_t e = 0; e < plan.edges.size(); ++e)
        CHECK(one.edges[e].points == all.edges[e].points);
}

TEST_CASE("smoothed plans are coarsened, carried along, grown from, and not refined", "[grid]") {
    const mesh::Cage cage = test::sample_cage("wing_fuselage/smooth.obj");
    const Plan plan = grid::make_plan(grid::make_layout(cage), {.cells = 8, .levels = 1});
    const Plan moved = grid::smoothed(plan);
    const Plan coarse = grid::coarsened(moved, 1);
    const grid::BlockEvaluator fine(moved), every_second(coarse);
    for (int b = 0; b < int(plan.layout.blocks.size()); ++b) {
        const grid::BlockPoints all = fine.evaluate(b), half = every_second.evaluate(b);
        for (int j = 0; j < half.nj; ++j)
            for (int i = 0; i < half.ni; ++i) CHECK(half.at(i, j) == all.at(2 * i, 2 * j));
    }
    // Everything is linear in the control points, the places stay.
    const Plan doubled = grid::with_points(moved, 2.0 * cage.points);
    const grid::BlockPoints a = fine.evaluate(0);
    const grid::BlockPoints b = grid::BlockEvaluator(doubled).evaluate(0);
    for (std::size_t n = 0; n < a.count(); ++n)
        CHECK(b.coordinates[0][n] == Approx(2.0 * a.coordinates[0][n]).margin(1e-9));
    const grid::LayerGrid layers(moved, {.cells = 3, .first_mm = 0.5});
    CHECK(grid::measure_quality(layers).negative == 0);
    CHECK_THROWS_AS(grid::smoothed(moved), base::InvalidArgument);
    CHECK_THROWS_AS(grid::refined(
                        moved, [](const Vec3&, const Vec3&, const Vec3&) { return 1.0; }, 0.5),
                    base::InvalidArgument);
    CHECK_THROWS_AS(fine.parameters(0), base::InvalidArgument);
    const base::Progress stop = [](std::string_view, double) { return false; };
    CHECK_THROWS_AS(grid::smoothed(plan, {.progress = stop}), base::Cancelled);
}

}  // namespace patchwright
