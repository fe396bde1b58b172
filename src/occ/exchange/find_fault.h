// Which entity of a file the kernel does not survive.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace patchwright::occ {

/// Gives the kernel every face of a STEP or IGES file by itself, in the order of the file; told
/// before each: "#17 ADVANCED_FACE", and at the end an empty text. For a process that may crash.
void find_fault(const std::filesystem::path& path,
                const std::function<void(const std::string&)>& tell);

}  // namespace patchwright::occ
