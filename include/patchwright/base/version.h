// The version of the library, the same that CMake's package file states.
#pragma once

#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// "major.minor.patch"
std::string_view version();

}  // namespace patchwright::base
#pragma GCC visibility pop
