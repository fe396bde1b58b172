// Figures of the patches, as JSON: random cages written to STEP and read back, and the cost of
// assembling and writing many faces beside sewing the same ones.
// Usage: bench_patches [SEEDS] [KEEP_FOLDER]
#include "occ/exchange/cad_model_impl.h"
#include "occ/random_patches.h"
#include "support/cages.h"

#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>

using namespace patchwright;
using Json = nlohmann::ordered_json;

namespace {

template <class Work>
double seconds(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Json random_cages(unsigned seeds, const std::filesystem::path& folder) {
    double gap = 0.0, kink = 0.0;
    int invalid = 0, not_bicubic = 0, edges = 0, exempt = 0, caps = 0, not_smooth = 0, no_plane = 0;
    const double time = seconds([&] {
        for (unsigned seed = 0; seed < seeds; ++seed) {
            const auto file = folder / ("cage_" + std::to_string(seed) + ".step");
            const test::RandomPatches result = test::write_random_patches(seed, file);
            gap = std::max(gap, result.relative_gap);
            kink = std::max(kink, result.kink_deg);
            invalid += result.inspection.valid ? 0 : 1;
            not_bicubic += result.inspection.all_bicubic ? 0 : 1;
            edges += result.smooth_edges;
            exempt += result.exempt_edges;
            caps += result.caps;
            not_smooth += result.caps_not_smooth;
            no_plane += result.caps_without_plane;
        }
    });
    return {{"cages", seeds},
            {"largest_gap_of_diagonal", gap},
            {"largest_kink_deg", kink},
            {"smooth_edges", edges},
            {"exempt_edges", exempt},
            {"caps", caps},
            {"caps_not_smooth", not_smooth},
            {"of_those_without_limit_tangent_plane", no_plane},
            {"not_valid", invalid},
            {"not_bicubic", not_bicubic},
            {"seconds", time}};
}

Json many_faces(int side, bool sew, const std::filesystem::path& folder) {
    const mesh::Cage cage = test::torus(side, side, 300, 100);
    const auto patches = patch::extract(cage, {.covering = patch::Covering::Faces}).patches;
    std::optional<occ::CadModel> model;
    const double assemble = seconds([&] { model = occ::assemble(patches); });
    const double write = seconds([&] { occ::write_cad(*model, folder / "faces.step"); });
    Json result = {{"faces", side * side},
                   {"assemble_us_a_face", 1e6 * assemble / (side * side)},
                   {"write_us_a_face", 1e6 * write / (side * side)},
                   {"bytes_a_face",
                    double(std::filesystem::file_size(folder / "faces.step")) / (side * side)}};
    if (sew) {
        // Loose copies of the same faces, each with edges of its own.
        std::vector<TopoDS_Shape> loose;
        for (const TopoDS_Face& face : occ::faces_of(*model)) {
            loose.push_back(BRepBuilderAPI_Copy(face).Shape());
        }
        const double time = seconds([&] {
            BRepBuilderAPI_Sewing sewing(1e-6);
            for (const TopoDS_Shape& face : loose) sewing.Add(face);
            sewing.Perform();
        });
        result["sewing_us_a_face"] = 1e6 * time / (side * side);
        result["sewing_over_assembly"] = time / assemble;
    }
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    const unsigned seeds = argc > 1 ? unsigned(std::atoi(argv[1])) : 200;
    const bool keep = argc > 2;
    const std::filesystem::path folder = keep ? std::filesystem::path(argv[2])
                                              : std::filesystem::temp_directory_path() /
                                                    ("bench_patches_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    Json result;
    result["random_cages"] = random_cages(seeds, folder);
    for (const int side : {25, 50, 100, 200}) {
        result["many_faces"].push_back(many_faces(side, side <= 50, folder));
    }
    std::cout << result.dump(2) << "\n";
    if (!keep) std::filesystem::remove_all(folder);
}
