#include <patchwright/base/parallel.h>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

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
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        body(chunk * step, std::min(count, (chunk + 1) * step));
    });
}

}  // namespace patchwright::base
