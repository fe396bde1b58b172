#include "cage/sections/recognise.h"

#include "cage/sections/tube.h"
#include "cage/sections/wing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::cage {

Recognised recognise(const Body& body, const geom::ModelSurface& reference, double fineness) {
    const WingOptions wing{.columns = std::max(5, int(std::lround(8 * std::sqrt(fineness)))),
                           .spans = std::max(1, int(std::lround(5 * fineness))),
                           .fineness = fineness};
    const WingSearch search = find_wing(body, reference, wing);
    if (search.wing)
        return {wing_blocks(*search.wing, reference, wing), describe(*search.wing, wing)};
    const TubeOptions options{
        .around = 8 * std::max(1, int(std::lround(2.0 * std::sqrt(fineness)))),
        .fineness = fineness};
    const TubeSearch around = find_tube(body, reference, options);
    if (around.tube) return {tube_blocks(*around.tube, reference), describe(*around.tube)};
    return {{}, fmt::format("no wing ({}), no nacelle ({})", search.why_not, around.why_not)};
}

}  // namespace patchwright::cage
