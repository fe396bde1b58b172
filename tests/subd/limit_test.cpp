#include "subd/solver_products.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <numeric>

using namespace patchwright;
using geom::Vec3;
using mesh::FaceId;
using mesh::VertexId;

TEST_CASE("limit position of a cube corner is half the corner", "[subd][oracle]") {
    // Valence 3, smooth: (9 v + 4 sum(e) + sum(f)) / 24 = 12/24 of the corner.
    CHECK(subd::limit_position(test::cube(2.0), VertexId{7}).isApprox(Vec3::Constant(0.5), 1e-14));
}

TEST_CASE("limit masks at smooth vertices are the closed form for any valence", "[subd][oracle]") {
    for (int n = 3; n <= 50; ++n) {
        CAPTURE(n);
        const mesh::Cage cage = test::fan(n);
        Vec3 expected = n * n * cage.points.row(0).transpose();
        for (int k = 0; k < 2 * n; ++k) {
            expected += (k % 2 == 0 ? 4.0 : 1.0) * cage.points.row(1 + k).transpose();
        }
        expected /= n * (n + 5.0);
        CHECK((subd::limit_position(cage, VertexId{0}) - expected).norm() < 1e-13);
    }
}

TEST_CASE("crease and corner limits are the curve's", "[subd][oracle]") {
    mesh::TopologyInput tags;
    for (const auto& [a, b] : {std::pair{4, 5}, {5, 7}, {7, 6}, {6, 4}}) {
        tags.creases.push_back({a, b, mesh::infinite_sharpness});
    }
    tags.corners.push_back({0, mesh::infinite_sharpness});
    const mesh::Cage cage = test::cube(2.0, tags);
    // (1, 4, 1) / 6 along the rim: the corner (1,1,1) with neighbours (-1,1,1) and (1,-1,1).
    CHECK(subd::limit_position(cage, VertexId{7}).isApprox(Vec3(2.0 / 3, 2.0 / 3, 1.0), 1e-14));
    CHECK(subd::limit_position(cage, VertexId{0}).isApprox(Vec3(-1, -1, -1), 1e-14));
}

TEST_CASE("a regular face is the uniform bicubic B-spline", "[subd][oracle]") {
    mesh::Cage cage = test::grid(3, 3);
    cage.points.col(2) = cage.points.col(0).array().square() * cage.points.col(1).array();
    const subd::LimitEvaluator evaluator(cage.topology);
    // A uniform cubic B-spline with coefficients i^2 is t^2 + 1/3; with i it is t.
    for (const double u : {0.0, 0.3, 1.0}) {
        for (const double v : {0.0, 0.6, 1.0}) {
            const Vec3 p = evaluator.position(cage.points, {FaceId{4}, u, v});
            const double x = 1 + u;
            const double y = 1 + v;
            CHECK(p.isApprox(Vec3(x, y, (x * x + 1.0 / 3) * y), 1e-14));
        }
    }
}

TEST_CASE("refining does not change the limit surface", "[subd][oracle]") {
    for (unsigned seed = 0; seed < 30; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = seed % 3 == 0});
        const subd::Refinement step = subd::refine(*cage.topology);
        const geom::Points fine_points = step.stencils.apply(cage.points);
        const subd::LimitEvaluator coarse(cage.topology);
        const subd::LimitEvaluator fine(step.topology);
        int child = 0;
        for (const FaceId f : cage.topology->faces()) {
            const int n = cage.topology->size(f);
            for (int i = 0; i < n; ++i, ++child) {
                for (const auto& [u, v] :
                     {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.3, 0.8}, {0.51, 0.0}, {1.0, 1.0}}) {
                    subd::Location at{f, u, v, i};
                    if (n == 4) {
                        at = {f, 0.5 * (u + (i == 1 || i == 2)), 0.5 * (v + (i >= 2)), 0};
                    }
                    const Vec3 a = coarse.position(cage.points, at);
                    const Vec3 b = fine.position(fine_points, {FaceId{child}, u, v});
                    CHECK((a - b).norm() < 1e-13 * 5);
                }
            }
        }
    }
}

TEST_CASE("limit points agree where faces meet", "[subd]") {
    for (unsigned seed = 40; seed < 60; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage =
            subd::refine(test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = true}), 1);
        const mesh::Topology& t = *cage.topology;
        const subd::LimitEvaluator evaluator(cage.topology);
        const auto on_side = [](FaceId f, int side, double s) {
            return side == 0   ? subd::Location{f, s, 0}
                   : side == 1 ? subd::Location{f, 1, s}
                   : side == 2 ? subd::Location{f, 1 - s, 1}
                               : subd::Location{f, 0, 1 - s};
        };
        for (const mesh::EdgeId e : t.edges()) {
            if (t.is_boundary(e)) continue;
            const mesh::CornerId c = t.corner(e);
            const mesh::CornerId d = t.twin(c);
            for (const double s : {0.0, 0.01, 0.37, 1.0}) {
                const auto side = [&](mesh::CornerId x) {
                    return x.value - t.corners(t.face(x))[0].value;
                };
                const Vec3 p = evaluator.position(cage.points, on_side(t.face(c), side(c), s));
                const Vec3 q = evaluator.position(cage.points, on_side(t.face(d), side(d), 1 - s));
                CHECK((p - q).norm() < 1e-13);
            }
        }
    }
}

TEST_CASE("a point that is not on the mesh is refused", "[subd][errors]") {
    const mesh::Cage cage = test::cube(1.0);
    const subd::LimitEvaluator evaluator(cage.topology);
    CHECK_THROWS_AS(evaluator.mask({FaceId{6}, 0, 0}), base::InvalidArgument);
    CHECK_THROWS_AS(evaluator.mask({FaceId{0}, 1.1, 0}), base::InvalidArgument);
    CHECK_THROWS_AS(evaluator.mask({FaceId{0}, 0, NAN}), base::InvalidArgument);
    CHECK_THROWS_AS(evaluator.mask({FaceId{0}, 0, 0, 1}), base::InvalidArgument);
}

namespace {

struct Sampled {
    mesh::Cage cage;
    std::vector<subd::Site> sites;
    std::vector<subd::ParameterSet> sets{{{0.25, 0.25}, {0.75, 0.3}},
                                         {{0.0, 0.0}, {0.4, 1.0}, {1.0, 1.0}}};
};

Sampled sampled(unsigned seed) {
    Sampled s{test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = seed % 3 == 0}), {}};
    for (const FaceId f : s.cage.topology->faces()) {
        const int sectors = s.cage.topology->size(f) == 4 ? 1 : s.cage.topology->size(f);
        for (int sector = 0; sector < sectors; ++sector)
            s.sites.push_back({f, sector, f.value % 2});
    }
    return s;
}

}  // namespace

TEST_CASE("the limit operator has the masks as rows", "[subd]") {
    for (unsigned seed = 0; seed < 12; ++seed) {
        const Sampled s = sampled(seed);
        const subd::LimitOperator op(*s.cage.topology, s.sets, s.sites);
        const subd::LimitEvaluator evaluator(s.cage.topology);
        geom::Points limit;
        op.apply(s.cage.points, limit);
        for (std::size_t i = 0; i < s.sites.size(); ++i) {
            const auto& set = s.sets[std::size_t(s.sites[i].set)];
            for (std::size_t k = 0; k < set.size(); ++k) {
                const Vec3 p = evaluator.position(
                    s.cage.points, {s.sites[i].face, set[k].x(), set[k].y(), s.sites[i].sector});
                CHECK((limit.row(op.site_rows()[i] + Eigen::Index(k)).transpose() - p).norm() <
                      1e-14);
            }
        }
        geom::Points ones;
        op.apply(geom::Points::Ones(op.columns(), 3), ones);
        CHECK((ones.array() - 1.0).abs().maxCoeff() < 1e-13);
    }
}

TEST_CASE("column squares are the diagonal of M^T W M", "[subd]") {
    const Sampled s = sampled(3);
    const subd::LimitOperator op(*s.cage.topology, s.sets, s.sites);
    const Eigen::VectorXd weights =
        Eigen::VectorXd::Random(Eigen::Index(s.sites.size())).cwiseAbs();
    Eigen::VectorXd plain(op.columns()), weighted(op.columns());
    for (Eigen::Index column = 0; column < op.columns(); ++column) {
        geom::Points unit = geom::Points::Zero(op.columns(), 3), rows;
        unit(column, 0) = 1.0;
        op.apply(unit, rows);
        plain[column] = rows.col(0).squaredNorm();
        weighted[column] = 0.0;
        for (std::size_t i = 0; i < s.sites.size(); ++i) {
            const auto first = op.site_rows()[i], count = op.site_rows()[i + 1] - first;
            weighted[column] +=
                weights[Eigen::Index(i)] * rows.col(0).segment(first, count).squaredNorm();
        }
    }
    // Sums of up to a hundred squares below 1.
    CHECK((subd::SolverProducts(op).column_squares() - plain).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((subd::SolverProducts(op).column_squares(weights) - weighted).cwiseAbs().maxCoeff() <
          1e-12);
}

TEST_CASE("<M x, y> = <x, M^T y>, bit for bit on any number of threads", "[subd]") {
    const Sampled s = sampled(5);
    const mesh::Cage fine = subd::refine(s.cage, 3);
    std::vector<subd::Site> sites;
    for (const FaceId f : fine.topology->faces()) sites.push_back({f, 0, 0});
    const subd::LimitOperator op(*fine.topology, {s.sets[0]}, sites);
    const geom::Points x = geom::Points::Random(op.columns(), 3);
    const geom::Points y = geom::Points::Random(op.rows(), 3);
    geom::Points mx, mty, again;
    base::set_thread_count(1);
    op.apply(x, mx);
    op.apply_transposed(y, mty);
    base::set_thread_count(0);
    op.apply_transposed(y, again);
    CHECK(again == mty);
    // Both products in one sweep, and with rows changed in between.
    op.apply(x, mx);
    op.apply_transposed(mx, mty);
    const Eigen::Array3d norms = subd::SolverProducts(op).normal_product(x, again);
    CHECK((again - mty).cwiseAbs().maxCoeff() < 1e-13 * mty.cwiseAbs().maxCoeff());
    CHECK((norms / mx.colwise().squaredNorm().transpose().array() - 1.0).abs().maxCoeff() < 1e-13);
    base::set_thread_count(1);
    geom::Points alone;
    CHECK((subd::SolverProducts(op).normal_product(x, alone) == norms).all());
    CHECK(alone == again);
    base::set_thread_count(0);
    const auto minus_y = [&](Eigen::Index first, subd::LimitOperator::Rows rows) -> Eigen::Array3d {
        rows -= y.middleRows(first, rows.rows());
        return Eigen::Array3d::Constant(double(rows.rows()));
    };
    CHECK((subd::SolverProducts(op).normal_product(x, again, minus_y) == double(op.rows())).all());
    op.apply_transposed(mx - y, mty);
    CHECK((again - mty).cwiseAbs().maxCoeff() < 1e-13 * mty.cwiseAbs().maxCoeff());
    op.apply_transposed(y, mty);
    const double left = (mx.array() * y.array()).sum();
    const double right = (x.array() * mty.array()).sum();
    CHECK(left == Approx(right).epsilon(1e-12));
    CHECK(op.template_count() < 60);
}

TEST_CASE("many locations at once are the same as one by one", "[subd]") {
    mesh::TopologyInput tags;
    tags.creases.push_back({4, 5, 2.5});
    const mesh::Cage cage = subd::refine(test::cube(2.0, tags), 1);
    const subd::LimitEvaluator evaluator(cage.topology);
    std::vector<std::int32_t> faces, sectors;
    std::vector<double> uv;
    for (int i = 0; i < 3000; ++i) {  // more than one task's
        faces.push_back(i % cage.topology->face_count());
        sectors.push_back(0);
        uv.push_back(i % 3 == 0 ? 0.0 : (i % 101) / 100.0);
        uv.push_back((i % 89) / 88.0);
    }
    for (const int order : {0, 1, 2}) {
        const Eigen::Index rows = subd::row_count(order);
        const geom::Points points = evaluator.evaluate(cage.points, {faces, uv, {}}, order);
        const subd::Stencils masks = evaluator.masks({faces, uv, sectors}, order);
        REQUIRE(points.rows() == 3000 * rows);
        for (std::size_t i = 0; i < faces.size(); i += 7) {
            const subd::Location at{FaceId{faces[i]}, uv[2 * i], uv[2 * i + 1]};
            const subd::LimitPoint one = evaluator.evaluate(cage.points, at, order);
            const Eigen::Index row = rows * Eigen::Index(i);
            CHECK(points.row(row).transpose() == one.position);
            if (order > 0) CHECK(points.row(row + 2).transpose() == one.dv);
            if (order > 1) CHECK(points.row(row + 5).transpose() == one.dvv);
        }
        CHECK((masks.apply(cage.points) - points).cwiseAbs().maxCoeff() < 1e-12);
    }
    const std::vector<subd::Smoothness> found = evaluator.smoothness({faces, uv, {}});
    CHECK(found[1] == subd::Smoothness::Derivatives);
    faces[5] = cage.topology->face_count();
    CHECK_THROWS_AS(evaluator.masks({faces, uv, {}}), base::UsageError);
    CHECK_THROWS_AS(evaluator.evaluate(cage.points, subd::Locations{{}, uv, {}}), base::UsageError);
    CHECK_THROWS_AS(evaluator.evaluate(geom::Points(3, 3), subd::Locations{}), base::UsageError);
}
