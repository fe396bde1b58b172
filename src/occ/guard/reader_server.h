// The reader's side: a server that starts a worker for each job, and the worker.
#pragma once

#include "occ/guard/read_request.h"

#include <sys/types.h>

namespace patchwright::occ {

/// Carries out jobs until nobody gives any. Call in a copy of a process without threads.
/// @param parent  ends it by ending
[[noreturn]] void serve_reads(int control, pid_t parent);

/// Exit statuses of a worker that can send nothing any more.
constexpr int out_of_memory_status = 10, stack_overflow_status = 11;

/// Reads, and sends the result or why there is none.
[[noreturn]] void read_in_worker(const ReadRequest& request, int channel);

}  // namespace patchwright::occ
