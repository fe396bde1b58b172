#include "grid/layer_rule.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <cmath>

namespace patchwright::grid {

namespace {

double first_height(const LayerOptions& options) {
    if (options.first_mm > 0.0) return options.first_mm;
    double sum = 0.0;
    for (int k = 0; k < options.cells; ++k) sum += std::pow(options.growth, k);
    return options.thickness_mm / sum;
}

}  // namespace

LayerRule wanted_rule(const LayerOptions& options) {
    if (options.cells < 1 || options.cells > 10000) {
        throw base::InvalidArgument(fmt::format("{} layers; use 1 to 10000", options.cells));
    }
    if (!(options.growth >= 0.5 && options.growth <= 5.0)) {
        throw base::InvalidArgument(fmt::format("layers grow by {}; use 0.5 to 5", options.growth));
    }
    if (!(options.first_mm > 0.0) && !(options.thickness_mm > 0.0)) {
        throw base::InvalidArgument("layers need the height of the first one or of all");
    }
    if (!(options.far_field_mm >= 0.0))
        throw base::InvalidArgument(fmt::format("a far field of {} mm", options.far_field_mm));
    return {first_height(options), options.growth};
}

}  // namespace patchwright::grid
