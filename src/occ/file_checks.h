// Whether a file is what its extension says and all of it is there, before the kernel sees it.
#pragma once

#include <filesystem>
#include <string>

namespace patchwright::occ {

/// The kernel's readers say "done" to cut-off files, and crash or loop forever on some; these do
/// not.
/// @throw InputError naming the file and what is missing
void check_step_file(const std::filesystem::path& path);
/// @return the whole file
std::string check_iges_file(const std::filesystem::path& path);
void check_brep_file(const std::filesystem::path& path);

}  // namespace patchwright::occ
