#include "fit/solve/mesh_preconditioner.h"

#include "fit/solve/cgls.h"
#include "fit/solve/limit_rows.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>
#include <cstring>

using namespace patchwright;
using geom::Points;

namespace {

/// The matrix, column by column: three of them in one product.
Eigen::MatrixXd dense(const fit::Preconditioner& b) {
    const Eigen::Index n = b.size();
    Eigen::MatrixXd matrix(n, n);
    for (Eigen::Index i = 0; i < n; i += 3) {
        Points unit = Points::Zero(n, 3), column = Points::Zero(n, 3);
        const Eigen::Index count = std::min<Eigen::Index>(3, n - i);
        for (Eigen::Index c = 0; c < count; ++c) unit(i + c, c) = 1.0;
        b.apply(unit, Eigen::Array3d::Zero(), column);
        matrix.middleCols(i, count) = column.leftCols(count);
    }
    return matrix;
}

subd::LimitOperator limits(const mesh::Cage& cage) {
    const subd::ParameterSet set{{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}};
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
    return {*cage.topology, {set}, sites};
}

}  // namespace

TEST_CASE("The mesh's change of unknowns is what its differences say", "[fit][oracle]") {
    const double a = 0.7;
    for (const mesh::Cage& cage :
         {test::torus(6, 5, 3, 1), test::grid(4, 3), test::fan(5), test::cube(2),
          test::random_cage(1, {.open = true}), test::random_cage(2, {.valence = 7})}) {
        const mesh::Topology& t = *cage.topology;
        const fit::MeshPreconditioner b(t, a);
        Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(b.size(), b.size());
        const auto add = [&](double weight, const std::vector<mesh::VertexId>& vertices) {
            Eigen::VectorXd d = Eigen::VectorXd::Zero(b.size());
            double sign = 1.0;
            for (const mesh::VertexId v : vertices) {
                d[v.value] += sign;
                sign = -sign;
            }
            expected += weight * d * d.transpose();
        };
        for (const mesh::EdgeId e : t.edges()) add(a, {t.start(e), t.end(e)});
        for (const mesh::FaceId f : t.faces()) {
            if (t.size(f) != 4) continue;
            const auto corner = [&](int i) { return t.vertex(t.corners(f)[i]); };
            add(a * a, {corner(0), corner(1), corner(2), corner(3)});
        }
        const Eigen::MatrixXd found = dense(b);
        CHECK((found - expected).cwiseAbs().maxCoeff() < 1e-13 * expected.maxCoeff());
        // It has an inverse, so that no solution is lost.
        CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(found).eigenvalues().minCoeff() >
              1.0 - 1e-12);
        std::srand(1);
        const Points s = Points::Random(b.size(), 3), start = Points::Random(b.size(), 3);
        Points once, twice = start;
        const Eigen::Array3d norms = b.apply_transposed(s, once);
        const Eigen::Array3d beta(0.5, 0.0, -2.0);
        b.apply(once, beta, twice);
        CHECK((once - found.transpose() * s).norm() < 1e-12 * once.norm());
        CHECK((norms - once.colwise().squaredNorm().transpose().array()).abs().maxCoeff() <
              1e-12 * norms.maxCoeff());
        CHECK((twice - found * once - start * beta.matrix().asDiagonal()).norm() <
              1e-12 * twice.norm());
    }
}

TEST_CASE("CGLS in the mesh's unknowns takes few steps, as many on any size", "[fit]") {
    for (const int size : {1, 2, 4}) {
        const mesh::Cage cage = test::torus(24 * size, 16 * size, 3, 1);
        const subd::LimitOperator limit = limits(cage);
        std::srand(7);
        const Points b = Points::Random(limit.rows(), 3);
        const Points zero = Points::Zero(limit.columns(), 3);
        const fit::MeshPreconditioner preconditioner(*cage.topology);
        const fit::CglsOptions plain{.max_iterations = 500, .relative_residual = 1e-10};
        fit::CglsOptions better = plain;
        better.preconditioner = &preconditioner;
        const auto slow = fit::solve_cgls(fit::LimitRows(limit), b, zero, plain);
        const auto fast = fit::solve_cgls(fit::LimitRows(limit), b, zero, better);
        CHECK((slow.x - fast.x).norm() < 1e-8 * slow.x.norm());
        CHECK(fast.residual == Approx(slow.residual).epsilon(1e-9));
        // Condition 9.7: a factor of at least 1.95 a step; 24 steps by theory for 1e-10 / 2.
        CHECK(fast.iterations < 45);
        CHECK(slow.iterations > 3 * fast.iterations);
    }
}

TEST_CASE("CGLS in the mesh's unknowns has the same bits on any number of threads", "[fit]") {
    const mesh::Cage cage = test::torus(160, 120, 3, 1);
    const subd::LimitOperator limit = limits(cage);
    std::srand(8);
    const Points b = Points::Random(limit.rows(), 3), zero = Points::Zero(limit.columns(), 3);
    const fit::MeshPreconditioner preconditioner(*cage.topology);
    const auto solve = [&](int threads) {
        base::set_thread_count(threads);
        return fit::solve_cgls(fit::LimitRows(limit), b, zero,
                               {.relative_residual = 1e-8, .preconditioner = &preconditioner})
            .x;
    };
    const Points one = solve(1), two = solve(2);
    base::set_thread_count(0);
    CHECK(std::memcmp(one.data(), two.data(), sizeof(double) * std::size_t(one.size())) == 0);
}

TEST_CASE("CGLS refuses unknowns of another mesh", "[fit][errors]") {
    const mesh::Cage cage = test::torus(6, 5, 3, 1);
    const subd::LimitOperator limit = limits(cage);
    const fit::MeshPreconditioner other(*test::cube(2).topology);
    CHECK_THROWS_AS(fit::solve_cgls(fit::LimitRows(limit), Points::Zero(limit.rows(), 3),
                                    Points::Zero(limit.columns(), 3), {.preconditioner = &other}),
                    base::InvalidArgument);
}
