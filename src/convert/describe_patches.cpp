#include "convert/describe_patches.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/deviation.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::convert {

namespace {

constexpr patch::Colour regular_colour{0.55, 0.67, 0.83}, cap_colour{0.93, 0.66, 0.35};
constexpr int deviation_steps = 8;  // of the colour scale: few colours, few styles in the file

geom::Vec3 middle_of(const geom::BsplineSurface& s) {
    return s.at(0.5 * s.knots_u.back(), 0.5 * s.knots_v.back()).position;
}

/// Blue, green, red, in steps.
patch::Colour scale_colour(double share) {
    const double t =
        std::min(int(share * deviation_steps), deviation_steps) / double(deviation_steps);
    return {std::clamp(2.0 * t - 1.0, 0.0, 1.0), 1.0 - std::abs(2.0 * t - 1.0),
            std::clamp(1.0 - 2.0 * t, 0.0, 1.0)};
}

}  // namespace

void describe_patches(patch::PatchSet& set, Colouring colouring,
                      const geom::ReferenceSurface* source, double tolerance_mm) {
    if (colouring == Colouring::Deviation && source == nullptr)
        throw base::InvalidArgument("colours by deviation need an input to deviate from");
    for (patch::Patch& patch : set.patches) {
        if (source != nullptr) {
            const int face = source->foot_point(middle_of(patch.surface)).face;
            patch.name = fmt::format("source face {}/{}", face, patch.name);
        }
        if (colouring == Colouring::Kind)
            patch.colour = patch.has_cap ? cap_colour : regular_colour;
        if (colouring == Colouring::Deviation) {
            patch.colour =
                scale_colour(measure::largest_deviation(patch.surface, *source) / tolerance_mm);
        }
    }
}

}  // namespace patchwright::convert
