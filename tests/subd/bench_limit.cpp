// Limit operators against OpenSubdiv, in one run: time and memory to build, rate of the products
// against a STREAM triad. Prints JSON.
//   bench_limit [FACES...]     1e4, 1e5 and 1e6 faces unless given
#include "subd/opensubdiv_oracle.h"
#include "support/bench.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace patchwright;
using nlohmann::ordered_json;
using test::best_seconds;
using test::seconds;
using test::triad_rate;

namespace {

constexpr int samples_along = 4;
constexpr int samples = samples_along * samples_along;
// Far keeps kilobytes a sample: more than this many faces do not fit a common machine's memory.
constexpr int most_faces_for_far = 150000;

/// A closed grid of about `faces` quads with some edges turned in their hexagon of two quads, which
/// makes two vertices of valence 3 and two of valence 5 each. One step of refinement isolates them.
mesh::Cage torus_with_turns(int faces, bool half_irregular) {
    const int nv = std::max(8, static_cast<int>(std::sqrt(faces / 4.0)) / 4 * 4);
    const int nu = std::max(8, faces / 4 / nv / 4 * 4);
    mesh::TopologyInput input;
    input.vertex_count = nu * nv;
    const auto at = [&](int i, int j) { return (i % nu) * nv + j % nv; };
    const auto add = [&](int a, int b, int c, int d) {
        input.face_sizes.push_back(4);
        for (const int v : {a, b, c, d}) input.face_vertices.push_back(v);
    };
    for (int i = 0; i < nu; i += 2) {
        for (int j = 0; j < nv; ++j) {
            const bool turn = j % 2 == 0 && i % 4 == 0 && (half_irregular || (i == 0 && j < 8));
            if (turn) {
                add(at(i, j), at(i + 1, j), at(i + 2, j), at(i + 2, j + 1));
                add(at(i, j), at(i + 2, j + 1), at(i + 1, j + 1), at(i, j + 1));
            } else {
                add(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                add(at(i + 1, j), at(i + 2, j), at(i + 2, j + 1), at(i + 1, j + 1));
            }
        }
    }
    geom::Points points(nu * nv, 3);
    for (int i = 0; i < nu; ++i) {
        for (int j = 0; j < nv; ++j) {
            const double a = 2 * M_PI * i / nu, b = 2 * M_PI * j / nv, r = 3 + std::cos(b);
            points.row(at(i, j)) << r * std::cos(a), r * std::sin(a), std::sin(b);
        }
    }
    return subd::refine(mesh::Cage{std::make_shared<const mesh::Topology>(input), points}, 1);
}

subd::ParameterSet sample_parameters() {
    subd::ParameterSet set;
    for (int i = 0; i < samples_along; ++i) {
        for (int j = 0; j < samples_along; ++j) {
            set.emplace_back((i + 0.5) / samples_along, (j + 0.5) / samples_along);
        }
    }
    return set;
}

/// Limit stencils of positions and first derivatives, as a user of OpenSubdiv makes them.
double time_far(const mesh::Topology& topology, std::size_t& bytes) {
    namespace Far = OpenSubdiv::Far;
    const auto refiner = test::osd_refiner(topology);
    std::vector<double> s, t;
    for (const auto& at : sample_parameters()) {
        s.push_back(at.x());
        t.push_back(at.y());
    }
    std::vector<Far::LimitStencilTableFactoryReal<double>::LocationArray> locations(
        std::size_t(topology.face_count()));
    for (std::size_t f = 0; f < locations.size(); ++f) {
        locations[f].ptexIdx = int(f);
        locations[f].numLocations = samples;
        locations[f].s = s.data();
        locations[f].t = t.data();
    }
    return seconds([&] {
        Far::PatchTableFactory::Options patch_options(6);  // exact for these parameters
        patch_options.useInfSharpPatch = true;
        patch_options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_BSPLINE_BASIS);
        refiner->RefineAdaptive(patch_options.GetRefineAdaptiveOptions());
        const std::unique_ptr<Far::PatchTable> patches(
            Far::PatchTableFactory::Create(*refiner, patch_options));
        Far::LimitStencilTableFactoryReal<double>::Options options;
        options.generate1stDerivatives = true;
        const std::unique_ptr<const Far::LimitStencilTableReal<double>> table(
            Far::LimitStencilTableFactoryReal<double>::Create(*refiner, locations, nullptr,
                                                              patches.get(), options));
        bytes = table->GetControlIndices().size() * (sizeof(int) + 3 * sizeof(double)) +
                table->GetSizes().size() * 2 * sizeof(int);
    });
}

/// Points and first derivatives at the same samples by Bfr.
double time_bfr(const mesh::Cage& cage, geom::Points& limit) {
    namespace Bfr = OpenSubdiv::Bfr;
    const auto refiner = test::osd_refiner(*cage.topology);
    const subd::ParameterSet set = sample_parameters();
    limit.resize(Eigen::Index(cage.topology->face_count()) * samples, 3);
    return seconds([&] {
        const Bfr::RefinerSurfaceFactory<> factory(*refiner);
        Bfr::Surface<double> surface;
        std::vector<double> patch_points;
        double du[3], dv[3];
        Eigen::Index row = 0;
        for (const mesh::FaceId f : cage.topology->faces()) {
            factory.InitVertexSurface(f.value, &surface);
            patch_points.resize(std::size_t(3 * surface.GetNumPatchPoints()));
            surface.PreparePatchPoints(cage.points.data(), 3, patch_points.data(), 3);
            for (const auto& at : set) {
                surface.Evaluate(at.data(), patch_points.data(), 3, limit.row(row++).data(), du,
                                 dv);
            }
        }
    });
}

ordered_json product_rates(const subd::LimitOperator& op, const mesh::Cage& cage) {
    geom::Points limit, back, first_limit, first_back;
    ordered_json result;
    // Indices, control points and samples, each once; all faces are quads.
    const double traffic = double(op.site_bytes()) + 24.0 * (op.columns() + op.rows());
    for (const int threads : {1, 2}) {
        base::set_thread_count(threads);
        op.apply(cage.points, limit);
        op.apply_transposed(limit, back);
        const double triad = triad_rate();
        const double apply = best_seconds(5, [&] { op.apply(cage.points, limit); });
        const double transposed = best_seconds(5, [&] { op.apply_transposed(limit, back); });
        result[fmt::format("threads_{}", threads)] = {
            {"triad_GB_s", triad / 1e9},
            {"apply_GB_s", traffic / apply / 1e9},
            {"apply_of_triad", traffic / apply / triad},
            {"transposed_GB_s", traffic / transposed / 1e9},
            {"transposed_of_triad", traffic / transposed / triad},
            {"apply_us_per_face", 1e6 * apply / cage.topology->face_count()},
            {"transposed_us_per_face", 1e6 * transposed / cage.topology->face_count()}};
        if (threads == 1) {
            first_limit = limit;
            first_back = back;
        } else {
            result["same_bits"] = first_limit == limit && first_back == back;
        }
    }
    base::set_thread_count(1);
    return result;
}

/// Nanoseconds a point with first derivatives, at several distances from vertices of valence 5.
ordered_json evaluation_times(const mesh::Cage& cage) {
    std::vector<mesh::FaceId> faces;
    for (const mesh::FaceId f : cage.topology->faces()) {
        if (cage.topology->valence(cage.topology->vertex(cage.topology->corners(f)[0])) == 5) {
            faces.push_back(f);
        }
    }
    const subd::LimitEvaluator evaluator(cage.topology);
    ordered_json result;
    double sum = 0.0;
    for (const double away : {0.3, 1e-3, 1e-6, 1e-9, 1e-12}) {
        const double best = best_seconds(3, [&] {
            for (int k = 0; k < 100000; ++k) {
                const mesh::FaceId f =
                    faces[std::size_t(k) % std::min<std::size_t>(faces.size(), 50)];
                sum += evaluator.evaluate(cage.points, {f, away, 0.6 * away}, 1).du.x();
            }
        });
        result[fmt::format("distance_{:g}", away)] = 1e9 * best / 100000;
    }
    if (!std::isfinite(sum)) std::fputs("bench_limit: points are not finite\n", stderr);
    return result;
}

ordered_json measure(int wanted_faces, bool half_irregular) {
    const mesh::Cage cage = torus_with_turns(wanted_faces, half_irregular);
    const int faces = cage.topology->face_count();
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
    const auto build = [&] {
        return subd::LimitOperator(*cage.topology, {sample_parameters()}, sites,
                                   subd::SampleRows::PointsAndTangents);
    };
    const double ours = best_seconds(3, [&] { build(); });
    const subd::LimitOperator op = build();
    ordered_json result{{"faces", faces},
                        {"half_irregular", half_irregular},
                        {"templates", op.template_count()},
                        {"bytes_per_face", double(op.site_bytes()) / faces},
                        {"template_bytes", op.template_bytes()},
                        {"build_us_per_face", 1e6 * ours / faces}};
    geom::Points limit, reference;
    const double bfr = time_bfr(cage, reference);
    op.apply(cage.points, limit);
    result["bfr_us_per_face"] = 1e6 * bfr / faces;
    result["bfr_over_build"] = bfr / ours;
    result["largest_difference"] = (limit - reference).rowwise().norm().maxCoeff();
    if (faces <= most_faces_for_far) {
        std::size_t bytes = 0;
        const double far = time_far(*cage.topology, bytes);
        result["far_us_per_face"] = 1e6 * far / faces;
        result["far_over_build"] = far / ours;
        result["far_bytes_per_sample"] = double(bytes) / (double(faces) * samples);
    }
    result["products"] = product_rates(op, cage);
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<int> sizes;
    for (int i = 1; i < argc; ++i) sizes.push_back(static_cast<int>(std::strtod(argv[i], nullptr)));
    if (sizes.empty()) sizes = {10000, 100000, 1000000};
    for (const int size : sizes) {
        if (size < 256) {
            std::fprintf(stderr, "bench_limit: FACES must be numbers of at least 256\n");
            return 2;
        }
    }
    base::set_thread_count(1);
    ordered_json report{{"samples_per_face", samples}};
    report["evaluate_ns"] = evaluation_times(torus_with_turns(10000, true));
    for (const int size : sizes) {
        for (const bool half : {false, true}) report["runs"].push_back(measure(size, half));
    }
    std::puts(report.dump(2).c_str());
}
