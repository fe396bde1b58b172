// The reader's side: a server that starts a worker for each job, and the worker.
#pragma once

#include "occ/guard/read_request.h"

#include <sys/types.h>

#include <optional>

namespace patchwright::occ {

/// Carries out jobs until nobody gives any. Call in a process without threads.
/// @param parent  ends it by ending; none: the end of the socket is enough, as no copies of the
///                parent hold it
[[noreturn]] void serve_reads(int control, std::optional<pid_t> parent);

/// Exit statuses of a worker that can send nothing any more.
constexpr int out_of_memory_status = 10, stack_overflow_status = 11;

/// Reads, and sends the result or why there is none.
[[noreturn]] void read_in_worker(const ReadRequest& request, int channel);

}  // namespace patchwright::occ
