// Whether a file is what its extension says and all of it is there, before the kernel sees it.
#pragma once

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <utility>

namespace patchwright::occ {

/// @throw InputError always: "FILE: what is wrong with it"
template <class... Args>
[[noreturn]] void refuse(const std::filesystem::path& path, fmt::format_string<Args...> format,
                         Args&&... args) {
    throw base::InputError(
        fmt::format("{}: {}", path.string(), fmt::format(format, std::forward<Args>(args)...)));
}

/// The kernel's readers say "done" to cut-off files, and crash or loop forever on some; these do
/// not.
/// @throw InputError naming the file and what is missing
/// @return the whole file
std::string check_step_file(const std::filesystem::path& path);
std::string check_iges_file(const std::filesystem::path& path);
void check_brep_file(const std::filesystem::path& path);

}  // namespace patchwright::occ
