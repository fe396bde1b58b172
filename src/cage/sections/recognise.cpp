#include "cage/sections/recognise.h"

#include "cage/sections/tube.h"
#include "cage/sections/wing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace patchwright::cage {

Recognised recognise(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const RecogniseOptions& options, Poll& poll) {
    const double fineness = options.fineness;
    const auto times = [](double factor, int count) { return int(std::lround(factor * count)); };
    const double root = std::sqrt(fineness);
    const WingOptions coarse_wing;
    const WingOptions wing{.columns = std::max(fewest_columns, times(root, coarse_wing.columns)),
                           .spans = std::max(1, times(fineness, coarse_wing.spans)),
                           .fineness = fineness,
                           .tolerance_mm = options.tolerance_mm};
    WingSearch search = find_wing(body, reference, wing, poll);
    if (search.wing) return {std::move(search.blocks), describe(*search.wing, wing)};
    const TubeOptions tube{.around = 8 * std::max(1, times(root, TubeOptions{}.around / 8)),
                           .fineness = fineness,
                           .tolerance_mm = options.tolerance_mm};
    const TubeSearch around = find_tube(body, reference, tube, poll);
    if (around.tube) return {tube_blocks(*around.tube, reference, poll), describe(*around.tube)};
    return {{}, fmt::format("no wing ({}), no nacelle ({})", search.why_not, around.why_not)};
}

}  // namespace patchwright::cage
