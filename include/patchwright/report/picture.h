// Pictures of a field, drawn without a display or a graphics library.
#pragma once

#include <patchwright/measure/field.h>

#include <string>

namespace patchwright::report {

struct PictureOptions {
    int width = 960, height = 540;  ///< pixels, positive
    /// From the model to the eye; z is up. Not zero.
    geom::Vec3 towards_eye = geom::Vec3(-0.55, -0.8, 0.6);
    double scale_mm = 1.0;  ///< deviation that is the last colour; positive
};

/// The surface in the colours of its deviation (grey where there is none), shaded, with the borders
/// of its faces and its sharp and free curves, on a transparent ground.
/// @return a PNG file's bytes
/// @throw InvalidArgument when an option is out of range
std::string to_png(const measure::Field& field, const PictureOptions& options = {});

}  // namespace patchwright::report
