// Colours of values between 0 and a scale, alike in files, pictures and the page's view.
#pragma once

#include <patchwright/base/colour.h>
#include <patchwright/measure/field.h>

#include <algorithm>
#include <array>
#include <initializer_list>

namespace patchwright::report {

/// Blue, cyan, green, yellow, red: of growing lightness up to yellow, told apart in print too.
inline constexpr std::array<base::Colour, 5> scale_stops{{{0.16, 0.22, 0.62},
                                                          {0.15, 0.60, 0.75},
                                                          {0.45, 0.78, 0.40},
                                                          {0.98, 0.82, 0.25},
                                                          {0.82, 0.15, 0.12}}};

/// @param share  of the scale; 1 and more are the last colour
inline base::Colour scale_colour(double share) {
    const double place = std::clamp(share, 0.0, 1.0) * double(scale_stops.size() - 1);
    const auto below = std::min(std::size_t(place), scale_stops.size() - 2);
    const base::Colour &a = scale_stops[below], &b = scale_stops[below + 1];
    const double t = place - double(below);
    return {a.red + t * (b.red - a.red), a.green + t * (b.green - a.green),
            a.blue + t * (b.blue - a.blue)};
}

/// Blue, white, red for -1, 0 and 1.
base::Colour diverging_colour(double share);

/// Of neighbouring numbers far apart: hues by the golden angle.
base::Colour face_colour(int face);

/// What nine tenths of the area of all fields keep below, 1/mm, so that colours mean the same on
/// all; null pointers are left out.
double usual_curvature(std::initializer_list<const measure::Field*> fields);

}  // namespace patchwright::report
