// What a parent asks a reader process for, as arguments of a program.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::occ {

enum class ReadTask {
    Read,
    FindFault  ///< give the kernel each face by itself, named before
};

struct ReadRequest {
    std::filesystem::path file;
    ReadTask task = ReadTask::Read;
    ReadOptions options;  ///< all but progress
    int threads = 0;
    double processor_s = 0.0;  ///< limits
    double memory_mb = 0.0;
    pid_t parent = 0;
};

std::vector<std::string> arguments_of(const ReadRequest& request);

/// Nothing when the arguments, with the program's name first, are others.
std::optional<ReadRequest> request_of(int argc, char** argv);

}  // namespace patchwright::occ
