// Reading in a process of its own against reading in this one, of the files given, as JSON: each
// time in a new process, as the command line does; processor time with that of the child.
#include "support/bench.h"

#include <patchwright/occ/guarded_read.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

using namespace patchwright;

namespace {

constexpr int repeats = 9;

struct Cost {
    double seconds = INFINITY, processor_seconds = INFINITY;
};

double processor_seconds(int who) {
    rusage usage{};
    getrusage(decltype(RUSAGE_SELF)(who), &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

Cost cost_of_read(const std::string& file, bool guarded) {
    const double before = processor_seconds(RUSAGE_SELF);
    Cost cost;
    cost.seconds = test::seconds([&] {
        if (!guarded) {
            occ::read_cad(file);
            return;
        }
        occ::ReaderProcess reader;
        occ::read_cad_guarded(file, reader);
    });
    cost.processor_seconds =
        processor_seconds(RUSAGE_SELF) - before + processor_seconds(RUSAGE_CHILDREN);
    return cost;
}

/// In a new process of this program.
Cost run_once(const std::string& file, const std::string& how) {
    const std::string command = fmt::format("{} {} '{}'", "/proc/$PPID/exe", how, file);
    FILE* output = ::popen(command.c_str(), "r");
    Cost cost;
    if (output == nullptr ||
        std::fscanf(output, "%lf %lf", &cost.seconds, &cost.processor_seconds) != 2)
        fmt::print(stderr, "{}: not read\n", file);
    if (output != nullptr) ::pclose(output);
    return cost;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc == 3 && (argv[1] == std::string("here") || argv[1] == std::string("guarded"))) {
        const Cost cost = cost_of_read(argv[2], argv[1] == std::string("guarded"));
        fmt::print("{} {}\n", cost.seconds, cost.processor_seconds);
        return 0;
    }
    nlohmann::json rows = nlohmann::json::array();
    std::array<Cost, 2> all{{{0.0, 0.0}, {0.0, 0.0}}};
    for (int i = 1; i < argc; ++i) {
        std::array<Cost, 2> least;
        for (int r = 0; r < repeats; ++r) {
            for (const std::size_t guarded : {0, 1}) {
                const Cost cost = run_once(argv[i], guarded != 0 ? "guarded" : "here");
                Cost& best = least[guarded];
                best.seconds = std::min(best.seconds, cost.seconds);
                best.processor_seconds = std::min(best.processor_seconds, cost.processor_seconds);
            }
        }
        for (const std::size_t guarded : {0, 1}) {
            all[guarded].seconds += least[guarded].seconds;
            all[guarded].processor_seconds += least[guarded].processor_seconds;
        }
        rows.push_back({{"file", argv[i]},
                        {"here_s", least[0].seconds},
                        {"guarded_s", least[1].seconds},
                        {"here_processor_s", least[0].processor_seconds},
                        {"guarded_processor_s", least[1].processor_seconds}});
    }
    const nlohmann::json report{
        {"repeats", repeats},
        {"files", rows},
        {"ratio", all[1].seconds / all[0].seconds},
        {"processor_ratio", all[1].processor_seconds / all[0].processor_seconds}};
    fmt::print("{}\n", report.dump(2));
}
