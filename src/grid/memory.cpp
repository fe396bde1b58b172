#include "grid/memory.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::grid {

void require_memory(double points, double bytes) {
    const double there = base::memory_bytes();
    if (bytes <= there) return;
    constexpr double giga = 1e9;
    throw base::UsageError(
        fmt::format("a grid of {:.3g} points needs {:.3g} GB of memory, and there are {:.3g} GB; "
                    "use larger cells",
                    points, bytes / giga, there / giga));
}

void require_memory(const Plan& plan, int layers, int kept_layers) {
    constexpr double coordinates = 3 * sizeof(double);
    double largest = 0.0;
    for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
        const auto [ni, nj] = plan.size(int(b));
        largest = std::max(largest, double(ni) * nj * layers);
    }
    const double surface = double(plan.point_count());
    require_memory(surface * layers,
                   largest * block_point_bytes + surface * kept_layers * coordinates);
}

}  // namespace patchwright::grid
