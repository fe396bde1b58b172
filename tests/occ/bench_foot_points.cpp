// Foot points of CadReference against the kernel's ways, in one run on one thread. Prints JSON.
//   bench_foot_points FILE... [--queries N]
#include "occ/shapes.h"

#include <patchwright/base/parallel.h>
#include <patchwright/occ/inspect.h>

#include <BRepAdaptor_Surface.hxx>
#include <BRepTools.hxx>
#include <Extrema_ExtPS.hxx>
#include <TopoDS.hxx>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdio>
#include <random>

using namespace patchwright;
using geom::Vec3;

namespace {

/// Microseconds a call of `body(query)`.
template <class Body>
double time_per_query(const std::vector<Vec3>& queries, std::size_t count, Body&& body) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < count; ++i) body(queries[i % queries.size()]);
    const std::chrono::duration<double, std::micro> spent =
        std::chrono::steady_clock::now() - start;
    return spent.count() / double(count);
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

nlohmann::ordered_json measure(const std::string& file, std::size_t count) {
    const occ::CadModel model = occ::read_cad(file).model;
    const auto start = std::chrono::steady_clock::now();
    const occ::CadReference reference(model);
    const std::chrono::duration<double> setup = std::chrono::steady_clock::now() - start;
    const double diagonal = reference.bounds().diagonal();

    // Random points within 1 % of the diagonal of the surface.
    std::mt19937 random(1);
    std::normal_distribution<> normal;
    std::uniform_real_distribution<> share;
    auto samples = reference.sample(int(count));
    std::shuffle(samples.begin(), samples.end(), random);
    std::vector<Vec3> queries;
    for (const auto& sample : samples) {
        const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
        queries.push_back(sample.point + 0.01 * diagonal * share(random) * direction);
    }
    double sum = 0.0;
    const double ours = time_per_query(
        queries, count, [&](const Vec3& p) { sum += reference.foot_point(p).distance; });
    FaceExtrema extrema(model);
    const std::size_t few = std::max<std::size_t>(count / 100, 20);
    const double ext_ps = time_per_query(queries, few, [&](const Vec3& p) { extrema.perform(p); });
    const TopoDS_Shape faces = test::faces_only(model.impl().shape);
    double farther = 0.0;
    const double dist_shape_shape = time_per_query(queries, few, [&](const Vec3& p) {
        const double kernel = test::kernel_distance(faces, p);
        if (kernel >= 0.0) farther = std::max(farther, reference.foot_point(p).distance - kernel);
    });
    return {{"file", std::filesystem::path(file).filename().string()},
            {"faces", occ::faces_of(model).size()},
            {"queries", count},
            {"setup_s", setup.count()},
            {"foot_point_us", ours},
            {"ext_ps_us", ext_ps},
            {"dist_shape_shape_us", dist_shape_shape},
            {"ratio_ext_ps", ext_ps / ours},
            {"ratio_dist_shape_shape", dist_shape_shape / ours},
            {"farther_than_kernel_rel", farther / diagonal},
            {"mean_distance_rel", sum / double(count) / diagonal}};
}

}  // namespace

int main(int argc, char** argv) {
    base::set_thread_count(1);
    std::size_t count = 20000;
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (int i = 1; i < argc; ++i) {
        if (std::string(argv[i]) == "--queries" && i + 1 < argc) {
            count = std::stoul(argv[++i]);
        } else {
            all.push_back(measure(argv[i], count));
        }
    }
    std::printf("%s\n", all.dump(2).c_str());
}
