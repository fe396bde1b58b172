#include <patchwright/base/parallel.h>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <vector>

namespace patchwright::base {

namespace {

std::unique_ptr<tbb::global_control>& thread_limit() {
    static std::unique_ptr<tbb::global_control> limit;
    return limit;
}

}  // namespace

void set_thread_count(int threads) {
    thread_limit().reset();
    if (threads > 0) {
        thread_limit() = std::make_unique<tbb::global_control>(
            tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
}

int thread_count() {
    const auto allowed =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return std::min(static_cast<int>(allowed), tbb::info::default_concurrency());
}

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
    const std::size_t step = std::max<std::size_t>(grain, 1);
    const std::size_t chunks = (count + step - 1) / step;
    if (chunks <= 1) {
        if (count > 0) body(0, count);
        return;
    }
    // Chunks may differ in cost by a thousand times: none is tied to the next.
    tbb::parallel_for(
        std::size_t{0}, chunks,
        [&](std::size_t chunk) { body(chunk * step, std::min(count, (chunk + 1) * step)); },
        tbb::simple_partitioner());
}

void run_tasks(std::size_t count, const std::function<void(std::size_t)>& task,
               const std::function<void()>& poll) {
    constexpr auto between_polls = std::chrono::milliseconds(30);
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stopped{false};
    std::mutex mutex;
    std::exception_ptr first;  // guarded by the mutex
    const auto attempt = [&](const auto& step) {
        try {
            step();
        } catch (...) {
            const std::lock_guard lock(mutex);
            if (!first) first = std::current_exception();
            stopped = true;
        }
    };
    const auto work = [&] {
        tbb::task_arena alone(1);
        for (std::size_t i = next++; i < count && !stopped; i = next++)
            attempt([&] { alone.execute([&] { task(i); }); });
    };
    std::vector<std::future<void>> threads;
    const auto limit = std::min(count, static_cast<std::size_t>(thread_count()));
    attempt([&] {
        for (std::size_t i = 0; i < limit; ++i)
            threads.push_back(std::async(std::launch::async, work));
    });
    for (const std::future<void>& thread : threads)
        while (thread.wait_for(between_polls) != std::future_status::ready)
            if (poll && !stopped) attempt(poll);
    if (first) std::rethrow_exception(first);
}

}  // namespace patchwright::base
