// Grids of ten million points: how long, how much memory, and what writing the bare bytes takes.
//
// Usage: bench_grid [POINTS [CAGE.obj [FOLDER]]]; prints JSON. Every case is a process of its own,
// so that peak memory is its own.
#include "support/cages.h"

#include <patchwright/base/parallel.h>
#include <patchwright/grid/write.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/refine.h>

#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

namespace {

using namespace patchwright;
namespace fs = std::filesystem;

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double peak_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) / 1024.0;
}

std::uintmax_t bytes_of(const fs::path& path) {
    if (!fs::is_directory(path)) return fs::file_size(path);
    std::uintmax_t sum = 0;
    for (const auto& entry : fs::directory_iterator(path)) sum += entry.file_size();
    return sum;
}

nlohmann::json grid_case(const mesh::Cage& cage, double points, const fs::path& file) {
    const double before = peak_mb();
    const double start = now();
    const grid::BlockLayout layout = grid::make_layout(cage);
    const auto blocks = double(layout.blocks.size());
    const int cells = std::max(1, int(std::lround(std::sqrt(points / blocks))) - 1);
    const grid::Plan plan = grid::make_plan(
        layout, {.cells = cells, .law = grid::Law::Cosine, .measure = grid::Measure::Curvature});
    const double planned = now();
    const grid::GridQuality quality = grid::write_grid(grid::SurfaceGrid(plan), file);
    const double written = now();
    std::uintmax_t bytes = bytes_of(file);
    if (file.extension() == ".vtm") bytes += bytes_of(file.parent_path() / file.stem());
    return {{"format", file.extension().string()},
            {"points", quality.points},
            {"blocks", quality.blocks},
            {"seconds", written - start},
            {"seconds_plan", planned - start},
            {"microseconds_a_point", 1e6 * (written - start) / double(quality.points)},
            {"megabytes_written", double(bytes) / 1e6},
            {"peak_memory_mb", peak_mb()},
            {"memory_over_output", (peak_mb() - before) * 1.048576 / (double(bytes) / 1e6)}};
}

/// The peer: as many bytes as the points have, from memory to a file.
nlohmann::json raw_case(double points, const fs::path& file) {
    const std::vector<double> part(1 << 16, 1.0);
    const double start = now();
    std::ofstream stream(file, std::ios::binary);
    auto left = std::size_t(3.0 * points);
    while (left > 0) {
        const std::size_t count = std::min(left, part.size());
        stream.write(reinterpret_cast<const char*>(part.data()),
                     std::streamsize(count * sizeof(double)));
        left -= count;
    }
    stream.close();
    return {{"format", "raw"}, {"seconds", now() - start}, {"megabytes_written", 24e-6 * points}};
}

/// Runs a case in a child process and reads its JSON.
template <class Case>
nlohmann::json in_child(const Case& run) {
    int ends[2];
    if (pipe(ends) != 0) return nullptr;
    const pid_t child = fork();
    if (child == 0) {
        const std::string text = run().dump();
        const bool sent = write(ends[1], text.data(), text.size()) == ssize_t(text.size());
        _exit(sent ? 0 : 1);
    }
    close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
        text.append(buffer, std::size_t(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    return status == 0 ? nlohmann::json::parse(text) : nlohmann::json(nullptr);
}

}  // namespace

int main(int argc, char** argv) {
    const double points = argc > 1 ? std::atof(argv[1]) : 1e7;
    const fs::path folder = argc > 3 ? fs::path(argv[3]) : fs::temp_directory_path();
    const fs::path base = folder / ("bench_grid" + std::to_string(getpid()));
    const std::string cage_file = argc > 2 ? argv[2] : "";
    nlohmann::json cases = nlohmann::json::array();
    const auto remove_files = [&](const std::string& extension) {
        fs::remove_all(base.string() + extension);
        fs::remove_all(base);
    };
    cases.push_back(in_child([&] { return raw_case(points, base.string() + ".raw"); }));
    remove_files(".raw");
    const double raw = cases[0]["seconds"];
    for (const std::string extension : {".xyz", ".cgns", ".vtm"}) {
        cases.push_back(in_child([&] {
            const mesh::Cage cage = cage_file.empty() ? subd::refine(test::cube(2.0), 3)
                                                      : mesh::read_obj(fs::path(cage_file)).cage;
            return grid_case(cage, points, base.string() + extension);
        }));
        remove_files(extension);
        if (cases.back().is_object()) {
            cases.back()["over_raw_write"] = double(cases.back()["seconds"]) / raw;
        }
    }
    std::cout << nlohmann::json{{"bench", "grid"},
                                {"threads", base::thread_count()},
                                {"compiler", __VERSION__},
                                {"cases", cases}}
                     .dump(2)
              << "\n";
    return 0;
}
