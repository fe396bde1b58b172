// Progress and cancellation: one callback, called from the thread that called the library.
#pragma once

#include <functional>
#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Called with the name of the running stage and its fraction done in [0, 1]; return false to stop.
/// An empty function reports nothing and never stops.
using Progress = std::function<bool(std::string_view stage, double fraction)>;

/// Reports, and turns a "stop" into an exception.
/// @throw Cancelled when the callback returns false
void report_progress(const Progress& progress, std::string_view stage, double fraction);

}  // namespace patchwright::base
#pragma GCC visibility pop
