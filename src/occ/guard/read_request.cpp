#include "occ/guard/read_request.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

namespace patchwright::occ {

namespace {

/// Hidden: no subcommand of that name is offered to users.
constexpr std::string_view command = "__read";
constexpr int argument_count = 11;
constexpr std::string_view no_unit = "-";

}  // namespace

std::vector<std::string> arguments_of(const ReadRequest& request) {
    const ReadOptions& options = request.options;
    return {std::string(command),
            request.file.string(),
            std::to_string(int(request.task)),
            std::string(options.unit ? base::short_name(*options.unit) : no_unit),
            std::to_string(int(options.allow_loss)),
            std::to_string(int(options.heal)),
            fmt::format("{}", options.max_sewing_tolerance_rel),
            std::to_string(request.threads),
            fmt::format("{}", request.processor_s),
            fmt::format("{}", request.memory_mb),
            std::to_string(request.parent)};
}

std::optional<ReadRequest> request_of(int argc, char** argv) {
    if (argc != argument_count + 1 || argv[1] != command) return std::nullopt;
    ReadRequest request{.file = argv[2], .task = ReadTask(std::atoi(argv[3]))};
    if (argv[4] != no_unit) request.options.unit = base::parse_length_unit(argv[4]);
    request.options.allow_loss = std::atoi(argv[5]) != 0;
    request.options.heal = std::atoi(argv[6]) != 0;
    request.options.max_sewing_tolerance_rel = std::atof(argv[7]);
    request.threads = std::atoi(argv[8]);
    request.processor_s = std::atof(argv[9]);
    request.memory_mb = std::atof(argv[10]);
    request.parent = pid_t(std::atol(argv[11]));
    return request;
}

}  // namespace patchwright::occ
