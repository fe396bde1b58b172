// How a run ends before its time: signals, memory used up, errors that nothing catches.
#pragma once

#include <string>

namespace patchwright::cli {

/// Catches INT, TERM, HUP, XFSZ and PIPE, unless they are ignored, memory used up (unless
/// base::MayRunOutOfMemory) and std::terminate. A signal asks the run to stop; when it has not
/// after a second and a half, its temporary files are removed and the process ends. Call first.
void catch_signals();

/// The signal that asked to stop; 0: none.
int stop_signal();

/// @throw Cancelled when a signal asked to stop
void stop_if_asked();

/// 128 and the signal's number, as shells have it.
int exit_code_of(int signal);
std::string message_of(int signal);

/// From now on signals change neither files nor this exit code: all outputs are in place.
void outputs_are_in_place(int exit_code);

/// Prints one line on standard error, unless one was printed.
void say_last_line(const std::string& text) noexcept;

constexpr const char* out_of_memory =
    "out of memory; no file was written or changed; use a coarser tolerance, fewer samples or a "
    "smaller cage";

/// Ends the process with the line above; allocates nothing, may be called before main() begins.
[[noreturn]] void end_without_memory() noexcept;

}  // namespace patchwright::cli
