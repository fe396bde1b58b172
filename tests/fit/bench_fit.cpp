// The solver of the fit against stored sparse matrices, in one run. Prints JSON.
//   bench_fit [VERTICES...]    1e3, 1e4, 1e5 and 1e6 unless given
#include "support/cages.h"

#include <patchwright/base/parallel.h>
#include <patchwright/fit/cgls.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace patchwright;
using geom::Points;
using nlohmann::ordered_json;

namespace {

template <class Body>
double seconds(Body&& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class LimitRows final : public fit::LinearOperator {
  public:
    explicit LimitRows(const subd::LimitOperator& limit) : limit_(limit) {}
    Eigen::Index rows() const override { return limit_.rows(); }
    Eigen::Index columns() const override { return limit_.columns(); }
    void apply(const Points& x, Points& y) const override { limit_.apply(x, y); }
    void apply_transposed(const Points& y, Points& x) const override {
        limit_.apply_transposed(y, x);
    }
    Eigen::Array3d apply_with_norms(const Points& x, Points& y) const override {
        return limit_.apply_with_norms(x, y);
    }
    void subtract_and_transpose(const Eigen::Array3d& factor, const Points& q, Points& r,
                                Points& x) const override {
        limit_.subtract_and_transpose(factor, q, r, x);
    }

  private:
    const subd::LimitOperator& limit_;
};

/// The same matrix in compressed rows with its transpose stored, three right-hand sides at once.
class SparseRows final : public fit::LinearOperator {
  public:
    using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    explicit SparseRows(Matrix matrix)
        : matrix_(std::move(matrix)), transposed_(matrix_.transpose()) {}
    Eigen::Index rows() const override { return matrix_.rows(); }
    Eigen::Index columns() const override { return matrix_.cols(); }
    void apply(const Points& x, Points& y) const override { product(matrix_, x, y); }
    void apply_transposed(const Points& y, Points& x) const override { product(transposed_, y, x); }
    const Matrix& matrix() const { return matrix_; }
    std::size_t bytes() const {
        return std::size_t(matrix_.nonZeros()) * 2 * (sizeof(double) + sizeof(int));
    }

  private:
    static void product(const Matrix& m, const Points& from, Points& to) {
        to.resize(m.rows(), 3);
        base::parallel_for(std::size_t(m.rows()), 8192, [&](std::size_t first, std::size_t last) {
            const int* begin = m.outerIndexPtr();
            const int* index = m.innerIndexPtr();
            const double* weight = m.valuePtr();
            for (std::size_t row = first; row < last; ++row) {
                double x = 0.0, y = 0.0, z = 0.0;
                for (int k = begin[row]; k < begin[row + 1]; ++k) {
                    const double* p = from.data() + 3 * std::ptrdiff_t(index[k]);
                    x += weight[k] * p[0];
                    y += weight[k] * p[1];
                    z += weight[k] * p[2];
                }
                double* q = to.data() + 3 * std::ptrdiff_t(row);
                q[0] = x;
                q[1] = y;
                q[2] = z;
            }
        });
    }

    Matrix matrix_, transposed_;
};

subd::ParameterSet grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) set.emplace_back((i + 0.5) / n, (j + 0.5) / n);
    }
    return set;
}

/// The operator's rows from masks of single points.
SparseRows::Matrix sparse_rows(const mesh::Cage& cage, const subd::ParameterSet& set) {
    const subd::LimitEvaluator evaluator(cage.topology);
    SparseRows::Matrix matrix(cage.topology->face_count() * Eigen::Index(set.size()),
                              cage.topology->vertex_count());
    matrix.reserve(Eigen::VectorXi::Constant(matrix.rows(), 18));
    Eigen::Index row = 0;
    for (const mesh::FaceId f : cage.topology->faces()) {
        for (const auto& at : set) {
            const subd::Mask mask = evaluator.mask({f, at.x(), at.y()});
            for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
                matrix.insert(row, mask.vertices[k]) = mask.rows(0, Eigen::Index(k));
            }
            ++row;
        }
    }
    matrix.makeCompressed();
    return matrix;
}

ordered_json measure(int vertices, int samples_along) {
    const int nv = std::max(4, static_cast<int>(std::sqrt(vertices / 2.0)));
    const mesh::Cage cage = test::torus(std::max(4, vertices / nv), nv, 3.0, 1.0);
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
    const subd::ParameterSet set = grid(samples_along);
    const subd::LimitOperator limit(*cage.topology, {set}, sites);
    const LimitRows ours(limit);
    const SparseRows sparse(sparse_rows(cage, set));
    Points target;
    limit.apply(cage.points, target);
    target += 0.01 * Points::Random(target.rows(), 3);
    const int steps = std::max(5, 2000000 / vertices);
    const auto per_step = [&](const fit::LinearOperator& op, Points& x) {
        double best = INFINITY;
        for (int run = 0; run < 3; ++run) {
            best = std::min(best, seconds([&] {
                                x = fit::solve_cgls(
                                        op, target, cage.points,
                                        {.max_iterations = steps, .relative_residual = 0.0})
                                        .x;
                            }));
        }
        return 1e9 * best / steps / cage.topology->vertex_count();
    };
    ordered_json result{
        {"vertices", cage.topology->vertex_count()},
        {"samples_per_face", samples_along * samples_along},
        {"bytes_per_vertex", double(limit.site_bytes()) / cage.topology->vertex_count()},
        {"sparse_bytes_over_ours", double(sparse.bytes()) / double(limit.site_bytes())}};
    for (const int threads : {1, 2}) {
        base::set_thread_count(threads);
        Points x, y;
        const double a = per_step(ours, x), b = per_step(sparse, y);
        result[fmt::format("threads_{}", threads)] = {
            {"ns_per_vertex_and_step", a},
            {"sparse_ns_per_vertex_and_step", b},
            {"sparse_over_ours", b / a},
            {"largest_difference", (x - y).cwiseAbs().maxCoeff()}};
    }
    // From zero to the same relative residual of the normal equations, on two threads.
    fit::CglsResult whole;
    const double solve = seconds([&] {
        whole = fit::solve_cgls(ours, target, Points::Zero(cage.points.rows(), 3),
                                {.max_iterations = 500, .relative_residual = 1e-8});
    });
    result["steps_to_1e-8_from_zero"] = whole.iterations;
    result["seconds_to_1e-8"] = solve;
    const Points solved = whole.x;
    // The same until no control point moves by more than a length: 1e-6 of the torus' tube.
    const double absolute = seconds([&] {
        whole = fit::solve_cgls(
            ours, target, Points::Zero(cage.points.rows(), 3),
            {.max_iterations = 500, .relative_residual = 0.0, .least_change = 1e-6});
    });
    result["steps_to_a_change_of_1e-6"] = whole.iterations;
    result["seconds_to_a_change_of_1e-6"] = absolute;
    if (vertices <= 100000) {
        Eigen::LeastSquaresConjugateGradient<SparseRows::Matrix> peer;
        peer.setTolerance(1e-8);
        peer.setMaxIterations(500);
        Points x(cage.points.rows(), 3);
        const double eigen = seconds([&] {
            peer.compute(sparse.matrix());
            for (int c = 0; c < 3; ++c) x.col(c) = peer.solve(Eigen::VectorXd(target.col(c)));
        });
        result["eigen_seconds_to_1e-8"] = eigen;
        result["eigen_over_ours"] = eigen / solve;
        result["eigen_largest_difference"] = (x - solved).cwiseAbs().maxCoeff();
    }
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<int> sizes;
    for (int i = 1; i < argc; ++i) sizes.push_back(static_cast<int>(std::strtod(argv[i], nullptr)));
    if (sizes.empty()) sizes = {1000, 10000, 100000, 1000000};
    ordered_json report;
    for (const int size : sizes) {
        if (size < 16) {
            std::fprintf(stderr, "bench_fit: VERTICES must be numbers of at least 16\n");
            return 2;
        }
        for (const int samples : {2, 4}) {
            // Stored matrices of 16 million rows do not fit a common machine.
            if (size > 300000 && samples > 2) continue;
            report["runs"].push_back(measure(size, samples));
        }
    }
    // Slopes of log time over log size, between the smallest and the largest size of each sampling.
    for (const int samples : {4, 16}) {
        std::vector<const ordered_json*> runs;
        for (const auto& run : report["runs"]) {
            if (run["samples_per_face"] == samples) runs.push_back(&run);
        }
        if (runs.size() < 2) continue;
        const auto slope = [&](const auto& value) {
            const auto &first = *runs.front(), &last = *runs.back();
            return std::log(value(last) / value(first)) /
                   std::log(last["vertices"].get<double>() / first["vertices"].get<double>());
        };
        report["slopes"][fmt::format("{}_samples", samples)] = {
            {"step", slope([](const ordered_json& run) {
                 return run["vertices"].get<double>() *
                        run["threads_2"]["ns_per_vertex_and_step"].get<double>();
             })},
            {"solve", slope([](const ordered_json& run) {
                 return run["seconds_to_a_change_of_1e-6"].get<double>();
             })}};
    }
    std::puts(report.dump(2).c_str());
}
