// The solver of the fit against stored sparse matrices, Eigen and CHOLMOD, in one run; steps of a
// fit and orders of convergence. Prints JSON.
//   bench_fit [VERTICES...]    1e3, 1e4, 1e5 and 1e6 unless given; 0: the orders alone
#include "fit/bench_orders.h"
#include "fit/bench_peers.h"
#include "fit/solve/limit_rows.h"
#include "fit/solve/mesh_preconditioner.h"
#include "support/analytic_references.h"
#include "support/bench.h"
#include "support/cages.h"

#include <patchwright/base/parallel.h>
#include <patchwright/fit/fit.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

using namespace patchwright;
using geom::Points;
using nlohmann::ordered_json;

namespace {

constexpr double major = 3.0, minor = 1.0;
// Whole solves end when no control point moves by more than this; the tube's radius is 1.
constexpr double step_tolerance = 1e-8;
// Stored rows beyond this take more memory than common machines have.
constexpr double most_entries = 5e8;

/// What all solves look for: closed grid of control points i * nv + j, limit points of each face at
/// n x n parameters, targets on a bent torus and a thousandth of its radius beside it.
struct Problem {
    int nu, nv;
    mesh::Cage cage;
    subd::ParameterSet set;
    subd::LimitOperator limit;
    Points target;
};

subd::ParameterSet grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) set.emplace_back((i + 0.5) / n, (j + 0.5) / n);
    }
    return set;
}

subd::LimitOperator limit_operator(const mesh::Cage& cage, const subd::ParameterSet& set) {
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
    return {*cage.topology, {set}, sites};
}

/// Between -1 and 1, the same for a number on every machine.
double noise(std::uint64_t i) {
    i = (i ^ (i >> 31)) * 0x7fb5d329728ea185ULL;
    i = (i ^ (i >> 27)) * 0x81dadef4bc2dd44dULL;
    i ^= i >> 33;
    return 2.0 * double(i >> 11) / 9007199254740992.0 - 1.0;
}

Problem problem(int nu, int nv, int samples_along) {
    mesh::Cage cage = test::torus(nu, nv, major, minor);
    const subd::ParameterSet set = grid(samples_along);
    subd::LimitOperator limit = limit_operator(cage, set);
    Points target(limit.rows(), 3);
    base::parallel_for(
        std::size_t(nu) * std::size_t(nv), 512, [&](std::size_t first, std::size_t last) {
            for (std::size_t f = first; f < last; ++f) {
                for (std::size_t k = 0; k < set.size(); ++k) {
                    const double a = 2 * M_PI * (double(f / std::size_t(nv)) + set[k].x()) / nu;
                    const double b = 2 * M_PI * (double(f % std::size_t(nv)) + set[k].y()) / nv;
                    const std::size_t row = f * set.size() + k;
                    const double tube = minor * (1 + 0.2 * std::cos(3 * a)) + 1e-3 * noise(row);
                    const double r = major + tube * std::cos(b);
                    target.row(Eigen::Index(row)) << r * std::cos(a), r * std::sin(a),
                        tube * std::sin(b) + 0.3 * std::sin(2 * a);
                }
            }
        });
    return {nu, nv, std::move(cage), set, std::move(limit), std::move(target)};
}

/// Control points of the same surface on a grid twice as fine: Catmull-Clark on regular faces.
Points refined(const Points& p, int nu, int nv) {
    const auto at = [&](int i, int j) {
        return p.row(Eigen::Index((i + nu) % nu) * nv + (j + nv) % nv);
    };
    Points half(Eigen::Index(2 * nu) * nv, 3), whole(Eigen::Index(4) * nu * nv, 3);
    for (int i = 0; i < nu; ++i) {
        for (int j = 0; j < nv; ++j) {
            half.row(Eigen::Index(2 * i) * nv + j) =
                (at(i - 1, j) + 6 * at(i, j) + at(i + 1, j)) / 8;
            half.row(Eigen::Index(2 * i + 1) * nv + j) = (at(i, j) + at(i + 1, j)) / 2;
        }
    }
    for (int i = 0; i < 2 * nu; ++i) {
        const auto of = [&](int j) { return half.row(Eigen::Index(i) * nv + (j + nv) % nv); };
        for (int j = 0; j < nv; ++j) {
            whole.row(Eigen::Index(i) * 2 * nv + 2 * j) = (of(j - 1) + 6 * of(j) + of(j + 1)) / 8;
            whole.row(Eigen::Index(i) * 2 * nv + 2 * j + 1) = (of(j) + of(j + 1)) / 2;
        }
    }
    return whole;
}

/// A solve that starts on a grid of at most 16 x 16 and goes on from each solution, refined.
struct Nested {
    Points start;  ///< of the finest grid
    fit::CglsResult finest;
    int coarse_steps = 0;
    double start_seconds = 0.0, finest_seconds = 0.0;
};

Nested solve_nested(const Problem& finest, int samples_along) {
    int levels = 0;
    while ((finest.nu >> levels) % 2 == 0 && (finest.nv >> levels) % 2 == 0 &&
           (finest.nv >> levels) > 16) {
        ++levels;
    }
    std::vector<Problem> coarse;  // operators and targets are made before the time is taken
    for (int k = levels; k > 0; --k) {
        coarse.push_back(problem(finest.nu >> k, finest.nv >> k, samples_along));
    }
    // Coarser levels have their own distances; more than a start is not to be had from them.
    const auto solve = [](const Problem& p, const Points& start, double change) {
        const fit::MeshPreconditioner preconditioner(*p.cage.topology);
        return fit::solve_cgls(fit::LimitRows(p.limit), p.target, start,
                               {.max_iterations = 500,
                                .relative_residual = 0.0,
                                .step_tolerance = change,
                                .preconditioner = &preconditioner});
    };
    Nested result;
    result.start = Points::Zero((coarse.empty() ? finest : coarse.front()).cage.points.rows(), 3);
    result.start_seconds = test::seconds([&] {
        for (const Problem& level : coarse) {
            const auto solved = solve(level, result.start, 1e-4);
            result.coarse_steps += solved.iterations;
            result.start = refined(solved.x, level.nu, level.nv);
        }
    });
    result.finest_seconds =
        test::seconds([&] { result.finest = solve(finest, result.start, step_tolerance); });
    return result;
}

ordered_json measure_steps(const Problem& p, const bench::StoredRows* stored, double triad) {
    const int n = p.cage.topology->vertex_count();
    const int steps = std::clamp(2000000 / n, 5, 200);
    const fit::CglsOptions options{.max_iterations = steps, .relative_residual = 0.0};
    const auto ns = [&](Points& x, const auto& solve) {
        // Steps alone: what a solve of no steps takes is subtracted.
        const double set_up =
            test::best_seconds(3, [&] { solve(fit::CglsOptions{.max_iterations = 0}); });
        const double all = test::best_seconds(5, [&] { x = solve(options).x; });
        return 1e9 * std::max(all - set_up, 0.0) / steps / n;
    };
    ordered_json result;
    Points x, y;
    const fit::LimitRows ours(p.limit);
    const double a = ns(x, [&](const fit::CglsOptions& o) {
        return fit::solve_cgls(ours, p.target, p.cage.points, o);
    });
    // Indices; d; the sum set, read and written; then x, s and d with what they come from.
    const double bytes = double(p.limit.site_bytes()) + 24.0 * n * (1 + 3 + 6 + 3);
    result["ns_per_vertex"] = a;
    result["of_triad"] = bytes / (1e-9 * a * n) / triad;
    if (stored != nullptr) {
        const double b = ns(y, [&](const fit::CglsOptions& o) {
            return stored->solve(p.target, p.cage.points, o);
        });
        const double stored_bytes =
            double(stored->bytes()) + 24.0 * double(p.limit.rows()) * 5 + 24.0 * n * 8;
        result["stored_ns_per_vertex"] = b;
        result["stored_of_triad"] = stored_bytes / (1e-9 * b * n) / triad;
        result["stored_over_ours"] = b / a;
        result["largest_difference"] = (x - y).cwiseAbs().maxCoeff();
    }
    return result;
}

ordered_json measure_solves(const Problem& p, const bench::StoredRows* stored, int samples_along) {
    const fit::LimitRows ours(p.limit);
    const Points zero = Points::Zero(p.cage.points.rows(), 3);
    const Nested nested = solve_nested(p, samples_along);
    const double seconds = nested.start_seconds + nested.finest_seconds;
    const Points exact = fit::solve_cgls(ours, p.target, nested.finest.x,
                                         {.max_iterations = 200, .relative_residual = 1e-9})
                             .x;
    const auto error = [&](const Points& x) { return (x - exact).cwiseAbs().maxCoeff(); };
    ordered_json result{
        {"step_tolerance", step_tolerance},        {"steps", nested.finest.iterations},
        {"steps_of_coarser", nested.coarse_steps}, {"seconds", seconds},
        {"of_them_coarser", nested.start_seconds}, {"error", error(nested.finest.x)}};
    fit::CglsResult from_zero;
    result["seconds_from_zero"] = test::seconds([&] {
        const fit::MeshPreconditioner preconditioner(*p.cage.topology);
        from_zero = fit::solve_cgls(ours, p.target, zero,
                                    {.max_iterations = 500,
                                     .relative_residual = 0.0,
                                     .step_tolerance = step_tolerance,
                                     .preconditioner = &preconditioner});
    });
    result["steps_from_zero"] = from_zero.iterations;
    fit::CglsResult plain;
    result["seconds_not_preconditioned"] = test::seconds([&] {
        plain = fit::solve_cgls(
            ours, p.target, nested.start,
            {.max_iterations = 500, .relative_residual = 0.0, .step_tolerance = step_tolerance});
    });
    result["steps_not_preconditioned"] = plain.iterations;
    if (stored == nullptr || samples_along != 2) return result;
    Points right;
    p.limit.apply_transposed(p.target, right);
    const double relative = nested.finest.normal_residual / right.norm();
    const auto eigen = bench::solve_eigen(stored->matrix(), p.target, nested.start, relative);
    // The same start, in the time that it took here.
    result["eigen"] = {{"relative_residual", relative},
                       {"steps", eigen.iterations},
                       {"seconds", nested.start_seconds + eigen.seconds},
                       {"error", error(eigen.x)},
                       {"over_ours", (nested.start_seconds + eigen.seconds) / seconds},
                       {"finest_over_ours", eigen.seconds / nested.finest_seconds}};
    const auto cholmod = bench::solve_cholmod(stored->matrix(), p.target);
    result["cholmod"] = {{"blas", cholmod.blas}, {"factor_GB", cholmod.factor_gb}};
    auto& entry = result["cholmod"];
    if (!cholmod.missing.empty()) {
        entry["missing"] = cholmod.missing;
        return result;
    }
    entry["form_seconds"] = cholmod.form;
    entry["analyze_seconds"] = cholmod.analyze;
    entry["factorize_seconds"] = cholmod.factorize;
    entry["solve_seconds"] = cholmod.solve;
    entry["error"] = error(cholmod.x);
    entry["over_ours"] = cholmod.seconds() / seconds;
    entry["factorize_and_solve_over_ours"] = (cholmod.factorize + cholmod.solve) / seconds;
    return result;
}

/// One projection and step of a fit to a torus, from a cage whose points are off at random, by a
/// twentieth of a face's width.
ordered_json measure_fit_step(int nu, int nv) {
    mesh::Cage cage = test::torus(nu, nv, major, minor);
    const double off = 0.05 * 2 * M_PI * minor / nv;
    for (Eigen::Index i = 0; i < cage.points.size(); ++i) {
        cage.points.data()[i] += off * noise(std::uint64_t(i));
    }
    fit::FitLevel level;
    const double seconds = test::best_seconds(cage.points.rows() > 300000 ? 1 : 3, [&] {
        level = fit::fit(cage, test::Torus(major, minor),
                         {.tolerance_mm = 1e-5,
                          .max_levels = 0,
                          .max_vertices = 10000000,
                          .solver = {.max_projections = 1, .samples_per_edge = 2}})
                    .levels.front();
    });
    return {{"seconds", seconds},
            {"us_per_vertex", 1e6 * seconds / double(cage.points.rows())},
            {"cgls_steps", level.cgls_steps}};
}

ordered_json measure(int vertices, int samples_along, const std::vector<double>& triads) {
    // Twice as many one way, and divisible by powers of two for the coarser grids.
    int levels = 0;
    const double side = std::sqrt(vertices / 2.0);
    while (side / (2 << levels) >= 11) ++levels;
    const int nv = std::max(4, int(std::lround(side / (1 << levels)))) << levels;
    const Problem p = problem(2 * nv, nv, samples_along);
    std::unique_ptr<bench::StoredRows> stored;
    if (16.0 * double(p.limit.rows()) <= most_entries) {
        stored = std::make_unique<bench::StoredRows>(bench::sparse_rows(p.cage, p.set));
    }
    const int n = p.cage.topology->vertex_count();
    ordered_json result{{"vertices", n},
                        {"samples_per_face", samples_along * samples_along},
                        {"bytes_per_vertex", double(p.limit.site_bytes()) / n}};
    if (stored) {
        result["stored_bytes_over_ours"] = double(stored->bytes()) / double(p.limit.site_bytes());
    }
    for (const int threads : {1, 2}) {
        base::set_thread_count(threads);
        result[fmt::format("step_on_{}", threads)] =
            measure_steps(p, stored.get(), triads[std::size_t(threads - 1)]);
    }
    result["solve"] = measure_solves(p, stored.get(), samples_along);
    if (samples_along == 2) result["fit_step"] = measure_fit_step(2 * nv, nv);
    return result;
}

/// Log of time over log of size, from each size to the next and from the first to the last.
ordered_json slopes(const std::vector<ordered_json>& runs,
                    const std::function<double(const ordered_json&)>& value) {
    const auto between = [&](const ordered_json& a, const ordered_json& b) {
        return std::log(value(b) / value(a)) /
               std::log(b["vertices"].get<double>() / a["vertices"].get<double>());
    };
    ordered_json result{{"whole", between(runs.front(), runs.back())}};
    for (std::size_t i = 1; i < runs.size(); ++i) {
        result["pieces"].push_back(between(runs[i - 1], runs[i]));
    }
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<int> sizes;
    for (int i = 1; i < argc; ++i) sizes.push_back(static_cast<int>(std::strtod(argv[i], nullptr)));
    const bool orders_only = sizes == std::vector<int>{0};
    if (orders_only) sizes.clear();
    if (argc == 1) sizes = {1000, 10000, 100000, 1000000};
    for (const int size : sizes) {
        if (size < 500) {
            std::fputs("bench_fit: VERTICES must be numbers of at least 500, or one 0\n", stderr);
            return 2;
        }
    }
    ordered_json report;
    std::vector<double> triads;  // bytes a second on one thread and on two
    for (const int threads : {1, 2}) {
        base::set_thread_count(threads);
        triads.push_back(test::triad_rate());
        report["triad_GB_s"].push_back(triads.back() / 1e9);
    }
    for (const int samples : {2, 4}) {
        std::vector<ordered_json> runs;
        for (const int size : sizes) {
            runs.push_back(measure(size, samples, triads));
            report["runs"].push_back(runs.back());
            std::fprintf(stderr, "%s\n", runs.back().dump().c_str());
        }
        if (runs.size() < 2) continue;
        auto& entry = report["slopes"][fmt::format("{}_samples", samples * samples)];
        entry["step"] = slopes(runs, [](const ordered_json& run) {
            return run["vertices"].get<double>() * run["step_on_2"]["ns_per_vertex"].get<double>();
        });
        entry["solve"] = slopes(
            runs, [](const ordered_json& run) { return run["solve"]["seconds"].get<double>(); });
        if (samples == 2) {
            entry["fit_step"] = slopes(runs, [](const ordered_json& run) {
                return run["fit_step"]["seconds"].get<double>();
            });
        }
    }
    if (argc == 1 || orders_only) {
        report["orders"] = bench::orders();
        report["quasi_interpolation"] = bench::quasi_interpolation();
    }
    std::puts(report.dump(2).c_str());
}
