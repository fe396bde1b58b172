#include "fit/solve/cgls.h"

#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

#include <Eigen/QR>

using namespace patchwright;

namespace {

class Dense final : public fit::LinearOperator {
  public:
    explicit Dense(Eigen::MatrixXd matrix) : matrix_(std::move(matrix)) {}
    Eigen::Index rows() const override { return matrix_.rows(); }
    Eigen::Index columns() const override { return matrix_.cols(); }
    void apply(const geom::Points& x, geom::Points& y) const override { y = matrix_ * x; }
    void apply_transposed(const geom::Points& y, geom::Points& x) const override {
        x = matrix_.transpose() * y;
    }

  private:
    Eigen::MatrixXd matrix_;
};

}  // namespace

TEST_CASE("CGLS is the dense QR solution", "[fit][oracle]") {
    std::srand(3);
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(60, 20);
    const geom::Points b = geom::Points::Random(60, 3);
    const geom::Points expected = a.householderQr().solve(Eigen::MatrixXd(b));
    const auto result =
        fit::solve_cgls(Dense(a), b, geom::Points::Zero(20, 3), {.relative_residual = 1e-14});
    CHECK((result.x - expected).norm() < 1e-11 * expected.norm());
    CHECK(result.residual == Approx((b - a * expected).norm()));
    // n steps suffice in exact arithmetic; rounding costs a few more.
    CHECK(result.iterations < 60);
}

TEST_CASE("CGLS stops after K steps and says so", "[fit]") {
    std::srand(4);
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(30, 20);
    const auto result = fit::solve_cgls(Dense(a), geom::Points::Random(30, 3),
                                        geom::Points::Zero(20, 3), {.max_iterations = 3});
    CHECK(result.iterations == 3);
    CHECK(result.stop == fit::CglsStop::MaxIterations);
}

TEST_CASE("CGLS stops when no unknown moves by more than a length", "[fit]") {
    std::srand(5);
    const Dense a(Eigen::MatrixXd::Random(60, 20));
    const geom::Points b = geom::Points::Random(60, 3), zero = geom::Points::Zero(20, 3);
    const auto whole = fit::solve_cgls(a, b, zero, {.relative_residual = 1e-14});
    const auto early =
        fit::solve_cgls(a, b, zero, {.relative_residual = 0.0, .step_tolerance = 1e-4});
    CHECK(early.iterations < whole.iterations);
    CHECK(early.stop == fit::CglsStop::StepTolerance);
    CHECK(whole.stop == fit::CglsStop::Residual);
    CHECK((early.x - whole.x).cwiseAbs().maxCoeff() < 1e-3);
    // The step before moved something by more.
    const auto before = fit::solve_cgls(a, b, zero, {.max_iterations = early.iterations - 1});
    const auto twice = fit::solve_cgls(a, b, zero, {.max_iterations = early.iterations - 2});
    CHECK((early.x - before.x).cwiseAbs().maxCoeff() <= 1e-4);
    CHECK((before.x - twice.x).cwiseAbs().maxCoeff() > 1e-4);
}

TEST_CASE("CGLS measures a step in the unit of what its unknowns stand for", "[fit]") {
    std::srand(6);
    const Dense a(Eigen::MatrixXd::Random(60, 20));
    const geom::Points b = geom::Points::Random(60, 3), zero = geom::Points::Zero(20, 3);
    const geom::Points sizes = geom::Points::Constant(20, 3, 1e3);
    const auto millimetres =
        fit::solve_cgls(a, b, zero, {.relative_residual = 0.0, .step_tolerance = 1e-4});
    const auto metres = fit::solve_cgls(
        a, b, zero, {.relative_residual = 0.0, .step_tolerance = 0.1, .unknown_sizes = &sizes});
    CHECK(metres.iterations == millimetres.iterations);
    const geom::Points few = geom::Points::Ones(3, 3);
    CHECK_THROWS_AS(fit::solve_cgls(a, b, zero, {.unknown_sizes = &few}), base::InvalidArgument);
}

TEST_CASE("CGLS with a zero right-hand side or an exact start takes no step", "[fit]") {
    const Dense identity(Eigen::MatrixXd::Identity(5, 5));
    const geom::Points b = geom::Points::Ones(5, 3);
    CHECK(fit::solve_cgls(identity, b, b).iterations == 0);
    CHECK(
        fit::solve_cgls(identity, geom::Points::Zero(5, 3), geom::Points::Zero(5, 3)).iterations ==
        0);
}

TEST_CASE("CGLS ends where it began when nothing but rounding is left to gain", "[fit]") {
    // Twice the same row asked for opposite values: A^T b is zero, or as near to it as rounding is.
    Eigen::MatrixXd rows = Eigen::MatrixXd::Random(2, 8);
    rows.row(1) = rows.row(0);
    geom::Points b(2, 3);
    b << 0.1, 0.2, 0.3, -0.1, -0.2, -0.3;
    const auto result = fit::solve_cgls(Dense(rows), b, geom::Points::Zero(8, 3));
    CHECK(result.x.cwiseAbs().maxCoeff() < 1e-10);
    CHECK(result.residual == Approx(b.norm()));
}

TEST_CASE("CGLS refuses sizes that do not match", "[fit][errors]") {
    const Dense identity(Eigen::MatrixXd::Identity(5, 5));
    CHECK_THROWS_AS(fit::solve_cgls(identity, geom::Points::Zero(4, 3), geom::Points::Zero(5, 3)),
                    base::InvalidArgument);
}
