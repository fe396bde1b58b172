// Foot points of CadReference against the kernel's ways and the bare nearest triangle, in one run.
// Times are processor time of one thread, the best of five rounds, but for the batch: wall time,
// one and two threads in turn. Prints JSON. The bare nearest triangle is one with its point; the
// tree alone knows its distance only. "kernel_missed": points the kernel finds nothing as near for,
// by 1e-9 of the diagonal.
//   bench_footpoint FILE... [--queries N] [--faces]
// --faces adds a wavy sheet cut into 10 to 10,000 faces.
#include "occ/foot_point_oracle.h"

#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>
#include <patchwright/occ/inspect.h>

#include <BRepAdaptor_Surface.hxx>
#include <BRepTools.hxx>
#include <Extrema_ExtPS.hxx>
#include <TopoDS.hxx>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <random>

using namespace patchwright;
using geom::Vec3;

namespace {

constexpr int rounds = 5;

double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Least processor time a call of `body(query)` in several rounds, microseconds.
template <class Body>
double time_per_query(const std::vector<Vec3>& queries, std::size_t count, int repeats,
                      Body&& body) {
    double best = 1e30;
    for (int round = 0; round < repeats; ++round) {
        const double start = processor_seconds();
        for (std::size_t i = 0; i < count; ++i) body(queries[i % queries.size()]);
        best = std::min(best, 1e6 * (processor_seconds() - start) / double(count));
    }
    return best;
}

/// Wall time of the batch call on some threads, microseconds a query.
double batch_time(const occ::CadReference& reference, const geom::Points& queries, int threads) {
    base::set_thread_count(threads);
    const auto start = std::chrono::steady_clock::now();
    const auto answers = reference.foot_points(queries);
    const std::chrono::duration<double, std::micro> spent =
        std::chrono::steady_clock::now() - start;
    base::set_thread_count(1);
    return spent.count() / double(answers.size());
}

/// The triangulation that CadReference searches, for searching it alone.
class BareTriangles {
  public:
    explicit BareTriangles(const occ::CadModel& model) {
        const occ::SearchableShape shape = occ::make_searchable(model.impl().shape);
        const double diagonal = occ::inspect(model).bounds.diagonal();
        std::vector<occ::FaceSurface> surfaces;
        for (const TopoDS_Face& face : shape.faces) surfaces.emplace_back(face, diagonal);
        mesh_ =
            occ::triangulate(shape, surfaces, occ::ReferenceOptions{}.deflection_rel * diagonal);
    }
    /// To the nearest triangle, in single precision: all that the tree itself knows.
    double distance(const Vec3& p) const {
        return mesh_.tree.nearest(p, 1e300, [](int, int count, const auto& near, double bound) {
            for (int i = 0; i < count; ++i)
                bound = std::min(bound, double(near.distance[std::size_t(i)]));
            return bound;
        });
    }
    /// A triangle and its point: the nearest but for single precision.
    std::pair<int, Vec3> nearest(const Vec3& p) const {
        int best = 0;
        mesh_.tree.nearest(p, 1e300, [&](int slot, int count, const auto& near, double bound) {
            for (int i = 0; i < count; ++i) {
                const auto distance = double(near.distance[std::size_t(i)]);
                best = distance < bound ? slot + i : best;
                bound = std::min(bound, distance);
            }
            return bound;
        });
        const std::int32_t number = mesh_.tree.numbers()[std::size_t(best)];
        const auto& corner = mesh_.triangles[std::size_t(number)].corner;
        const Vec3 w = geom::nearest_weights(p, corner);
        return {number, w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2]};
    }
    std::size_t size() const { return mesh_.triangles.size(); }

  private:
    occ::ReferenceMesh mesh_;
};

/// Random points within 1 % of the diagonal of the surface.
std::vector<Vec3> queries_near(const occ::CadReference& reference, std::size_t count) {
    const double diagonal = reference.bounds().diagonal();
    std::mt19937 random(1);
    std::normal_distribution<> normal;
    std::uniform_real_distribution<> share;
    auto samples = reference.sample(int(count));
    std::shuffle(samples.begin(), samples.end(), random);
    samples.resize(std::min(samples.size(), count));
    std::vector<Vec3> queries;
    for (const auto& sample : samples) {
        const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
        queries.push_back(sample.point + 0.01 * diagonal * share(random) * direction);
    }
    return queries;
}

/// The kernel's extrema, initialised once a face.
class FaceExtrema {
  public:
    explicit FaceExtrema(const occ::CadModel& model) {
        for (const TopoDS_Face& face : occ::faces_of(model)) {
            surfaces_.push_back(std::make_unique<BRepAdaptor_Surface>(face));
            double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
            BRepTools::UVBounds(face, u0, u1, v0, v1);
            auto extrema = std::make_unique<Extrema_ExtPS>();
            extrema->SetFlag(Extrema_ExtFlag_MIN);
            extrema->SetAlgo(Extrema_ExtAlgo_Grad);
            extrema->Initialize(*surfaces_.back(), u0, u1, v0, v1, 1e-9, 1e-9);
            extrema_.push_back(std::move(extrema));
        }
    }
    void perform(const Vec3& p) {
        for (const auto& extrema : extrema_) extrema->Perform(gp_Pnt(p.x(), p.y(), p.z()));
    }

  private:
    std::vector<std::unique_ptr<BRepAdaptor_Surface>> surfaces_;
    std::vector<std::unique_ptr<Extrema_ExtPS>> extrema_;
};

nlohmann::ordered_json measure(const std::string& name, const occ::CadModel& model,
                               std::size_t count, bool against_kernel) {
    const auto start = std::chrono::steady_clock::now();
    const occ::CadReference reference(model);
    const std::chrono::duration<double> setup = std::chrono::steady_clock::now() - start;
    const double diagonal = reference.bounds().diagonal();
    // Ten times as many for the batch: no two alike, as none is cheaper than the same one again.
    const std::vector<Vec3> many = queries_near(reference, 10 * count);
    const std::vector<Vec3> queries(many.begin(),
                                    many.begin() + std::ptrdiff_t(std::min(count, many.size())));
    double sum = 0.0;
    const double ours = time_per_query(
        queries, count, rounds, [&](const Vec3& p) { sum += reference.foot_point(p).distance; });
    const BareTriangles bare(model);
    const double triangles = time_per_query(
        queries, count, rounds, [&](const Vec3& p) { sum += (bare.nearest(p).second - p).norm(); });
    const double distances =
        time_per_query(queries, count, rounds, [&](const Vec3& p) { sum += bare.distance(p); });
    geom::Points batch(Eigen::Index(many.size()), 3);
    for (std::size_t i = 0; i < many.size(); ++i) batch.row(Eigen::Index(i)) = many[i].transpose();
    double one = 1e30, two = 1e30;
    for (int round = 0; round < rounds; ++round) {
        one = std::min(one, batch_time(reference, batch, 1));
        two = std::min(two, batch_time(reference, batch, 2));
    }
    nlohmann::ordered_json json{{"model", name},
                                {"faces", occ::faces_of(model).size()},
                                {"triangles", bare.size()},
                                {"queries", count},
                                {"setup_s", setup.count()},
                                {"foot_point_us", ours},
                                {"nearest_triangle_us", triangles},
                                {"triangle_distance_us", distances},
                                {"ratio_nearest_triangle", ours / triangles},
                                {"ratio_triangle_distance", ours / distances},
                                {"batch_us_1_thread", one},
                                {"batch_us_2_threads", two},
                                {"speedup_2_threads", one / two}};
    if (!against_kernel) return json;

    FaceExtrema extrema(model);
    const std::size_t few = std::max<std::size_t>(count / 100, 20);
    const double ext_ps =
        time_per_query(queries, few, 2, [&](const Vec3& p) { extrema.perform(p); });
    const TopoDS_Shape faces = test::faces_only(model.impl().shape);
    const auto search = [&](const Vec3& p, Extrema_ExtFlag flag) {
        const TopoDS_Vertex vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(p.x(), p.y(), p.z()));
        const BRepExtrema_DistShapeShape found(vertex, faces, flag);
        return found.IsDone() ? found.Value() : -1.0;
    };
    double farther = 0.0, nearer = 0.0;
    int compared = 0, missed = 0;
    const double least = time_per_query(queries, few, 1, [&](const Vec3& p) {
        const double kernel = search(p, Extrema_ExtFlag_MIN);
        if (kernel < 0.0) return;
        const double found = reference.foot_point(p).distance;
        ++compared;
        farther = std::max(farther, found - kernel);
        nearer = std::max(nearer, kernel - found);
        missed += kernel - found > 1e-9 * diagonal ? 1 : 0;
    });
    // As called with its defaults.
    const double standard = time_per_query(
        queries, few, 1, [&](const Vec3& p) { sum += search(p, Extrema_ExtFlag_MINMAX); });
    json["ext_ps_us"] = ext_ps;
    json["dist_shape_shape_us"] = standard;
    json["dist_shape_shape_min_us"] = least;
    json["ratio_ext_ps"] = ext_ps / ours;
    json["ratio_dist_shape_shape"] = standard / ours;
    json["ratio_dist_shape_shape_min"] = least / ours;
    json["batch_ratio_ext_ps"] = ext_ps / one;
    json["batch_ratio_dist_shape_shape"] = standard / one;
    json["compared"] = compared;
    json["farther_than_kernel_rel"] = farther / diagonal;
    json["kernel_farther_rel"] = nearer / diagonal;
    json["kernel_missed"] = missed;
    json["checksum"] = sum;  // keeps the compiler from leaving out what is timed
    return json;
}

}  // namespace

int main(int argc, char** argv) {
    base::set_thread_count(1);
    std::size_t count = 20000;
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--queries" && i + 1 < argc) {
            count = std::stoul(argv[++i]);
        } else if (argument == "--faces") {
            for (const int side : {3, 10, 32, 100})
                all.push_back(measure("wavy sheet", test::wavy_sheet(side), count, false));
        } else {
            all.push_back(measure(std::filesystem::path(argument).filename().string(),
                                  occ::read_cad(argument).model, count, true));
        }
    }
    std::printf("%s\n", all.dump(2).c_str());
}
