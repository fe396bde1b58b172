// Pictures of a field, drawn without a display or a graphics library.
#pragma once

#include <patchwright/measure/field.h>

#include <string>

#pragma GCC visibility push(default)
namespace patchwright::report {

enum class PictureLayer {
    Deviation,    ///< from the other model; grey where there is none
    NormalAngle,  ///< between tangent planes; red: the largest one
    Curvature,    ///< mean; blue bends away, red towards the eye
    Patches,      ///< each face in a colour of its own
    Zebra,        ///< the reflection of long lamps
    Plain
};

struct PictureOptions {
    int width = 960, height = 540;  ///< pixels, 1 to 8192
    PictureLayer layer = PictureLayer::Deviation;
    /// From the model to the eye; z is up. Not zero.
    geom::Vec3 towards_eye = geom::Vec3(-0.55, -0.8, 0.6);
    double scale_mm = 1.0;        ///< deviation that is the last colour; positive
    bool is_transparent = false;  ///< the ground; else white
};

/// The surface in the colours of a layer, shaded, with the borders of its faces and its sharp and
/// free curves.
/// @return a PNG file's bytes
/// @throw InvalidArgument when an option is out of range
std::string to_png(const measure::Field& field, const PictureOptions& options = {});

}  // namespace patchwright::report
#pragma GCC visibility pop
