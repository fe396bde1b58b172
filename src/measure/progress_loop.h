// Loops over many like items, on all threads, that report how far they are.
#pragma once

#include <patchwright/base/parallel.h>
#include <patchwright/base/progress.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace patchwright::measure {

/// Calls `body(i)` for each i from `first` to before `end`, on any thread, `grain` at a time.
/// Progress is reported from the calling thread only: before each block of items.
/// @throw Cancelled or TimeLimitReached from the progress callback
template <class Body>
void loop_with_progress(std::size_t first, std::size_t end, std::size_t block, std::size_t grain,
                        std::string_view stage, const base::Progress& progress, Body&& body) {
    for (std::size_t start = first; start < end; start += block) {
        base::report_progress(progress, stage, double(start) / double(end));
        base::parallel_for(std::min(block, end - start), grain,
                           [&](std::size_t begin, std::size_t stop) {
                               for (std::size_t i = start + begin; i < start + stop; ++i) body(i);
                           });
    }
}

}  // namespace patchwright::measure
