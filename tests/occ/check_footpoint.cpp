// Foot points of CAD files against BRepExtrema_DistShapeShape at points of all kinds. Prints JSON;
// fails when an answer is farther than the kernel's by more than 1e-7 of the diagonal and the
// file's tolerance.
//   check_footpoint FILE... [--points N]
#include "occ/foot_point_oracle.h"

#include <patchwright/occ/inspect.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdio>
#include <filesystem>

using namespace patchwright;

int main(int argc, char** argv) {
    int count = 2000, bad = 0;
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (int i = 1; i < argc; ++i) {
        if (std::string(argv[i]) == "--points" && i + 1 < argc) {
            count = std::stoi(argv[++i]);
            continue;
        }
        const auto start = std::chrono::steady_clock::now();
        const occ::CadModel model = occ::read_cad(argv[i]).model;
        const occ::CadReference reference(model);
        const double size = reference.bounds().diagonal();
        const double tolerance = 1e-7 * size + occ::inspect(model).max_tolerance_mm;
        // A tenth more, as the kernel gives no answer for some.
        const test::OracleResult found = test::compare_with_kernel(
            reference, test::faces_only(model.impl().shape), count + count / 10, 1, tolerance);
        const bool good = found.farther <= tolerance && found.points >= count;
        bad += good ? 0 : 1;
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        const auto& at = found.worst.point;
        all.push_back({{"file", std::filesystem::path(argv[i]).filename().string()},
                       {"good", good},
                       {"points", found.points},
                       {"kinds", found.kinds},
                       {"farther_rel", found.farther / size},
                       {"allowed_rel", tolerance / size},
                       {"worst_kind", found.worst.kind},
                       {"worst_at", {at.x(), at.y(), at.z()}},
                       {"kernel_farther", found.kernel_farther},
                       {"seconds", spent.count()}});
        std::fprintf(stderr, "%s: %s, %.1f s\n", argv[i], good ? "good" : "BAD", spent.count());
    }
    std::printf("%s\n", all.dump(2).c_str());
    return bad == 0 ? 0 : 1;
}
