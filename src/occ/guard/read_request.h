// What a process asks its reader for.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <filesystem>
#include <string>

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
};

std::string pack_request(const ReadRequest& request);
ReadRequest unpack_request(const std::string& bytes);

}  // namespace patchwright::occ
