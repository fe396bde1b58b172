// Heights of the layers over a point.
#pragma once

#include <patchwright/grid/layers.h>

#include <algorithm>

namespace patchwright::grid {

/// Heights shrink by no more from layer to layer (stretching of 3.3).
constexpr double least_growth = 0.3;

/// The first height and its growth.
struct LayerRule {
    double first_mm = 0.0, growth = 1.0;

    [[nodiscard]] double thickness(int cells) const {
        double sum = 0.0, height = first_mm;
        for (int k = 0; k < cells; ++k, height *= growth) sum += height;
        return sum;
    }
    /// The rule that is nearest to this one with no more than a thickness: growth is less first,
    /// down to least_growth.
    [[nodiscard]] LayerRule within(double thickness_mm, int cells) const {
        if (thickness(cells) <= thickness_mm) return *this;
        double low = std::min(least_growth, growth), high = growth;
        for (int step = 0; step < 60; ++step) {
            const double middle = 0.5 * (low + high);
            (LayerRule{first_mm, middle}.thickness(cells) > thickness_mm ? high : low) = middle;
        }
        const LayerRule rule{first_mm, low};
        return {first_mm * std::min(1.0, thickness_mm / rule.thickness(cells)), low};
    }
};

/// @throw InvalidArgument for options out of range
LayerRule wanted_rule(const LayerOptions& options);

}  // namespace patchwright::grid
