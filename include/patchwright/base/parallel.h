// Parallel loops whose results do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Limits all parallel loops of the process to `threads` (0: as many as there are cores).
void set_thread_count(int threads);

/// Number of threads the parallel loops may use.
int thread_count();

/// Calls `body(begin, end)` over consecutive chunks of [0, count) of `grain` items each (the last
/// may be shorter), in any order and on any thread. Chunk limits depend on `count` and `grain`
/// only, so a reduction that stores one value per chunk and adds them in chunk order is
/// reproducible. An exception of any chunk is rethrown after all running chunks have ended.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body);

/// Calls `task(i)` for each i in [0, count), begun in this order, as many at a time as
/// thread_count() says; parallel loops within a task stay on its thread. For few long pieces of
/// work. Meanwhile calls `poll`, if any, from the calling thread, some thirty times a second.
/// The first exception, of a task or of `poll`, is rethrown once the tasks that run have ended; no
/// others begin. Where `poll` throws it has to make them end as well.
void run_tasks(std::size_t count, const std::function<void(std::size_t)>& task,
               const std::function<void()>& poll = {});

}  // namespace patchwright::base
#pragma GCC visibility pop
