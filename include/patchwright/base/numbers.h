// Shorthand for numbers.
#pragma once

#include <cstddef>
#include <limits>

#pragma GCC visibility push(default)
namespace patchwright::base {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// An index that is an int, for containers. @pre i >= 0
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace patchwright::base
#pragma GCC visibility pop
