// Pictures of a field, drawn without a display or a graphics library.
#pragma once

#include <patchwright/measure/field.h>

#include <optional>
#include <string>
#include <vector>

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

/// What of the model is seen, in millimetres.
struct PictureFrame {
    geom::Vec3 centre;
    double width = 0.0;  ///< positive
};

struct PictureOptions {
    int width = 960, height = 540;  ///< pixels, 1 to 8192
    PictureLayer layer = PictureLayer::Deviation;
    /// From the model to the eye; z is up. Not zero.
    geom::Vec3 towards_eye = geom::Vec3(-0.55, -0.8, 0.6);
    std::optional<PictureFrame> frame;  ///< none: the whole model
    double scale_mm = 1.0;              ///< deviation that is the last colour; positive
    bool is_transparent = false;        ///< the ground; else white
};

/// An edge of a mesh, or several in a row.
struct PictureLine {
    enum class Kind {
        Plain,      ///< thin and dark
        SemiSharp,  ///< pale green
        Crease,     ///< green
        Border      ///< red: of an open surface or of blocks
    };
    geom::Points points;
    Kind kind = Kind::Plain;
};

/// The surface in the colours of a layer, shaded, with the borders of its faces and its sharp and
/// free curves.
/// @param edges  of a mesh, on the surface
/// @return a PNG file's bytes
/// @throw InvalidArgument when an option is out of range
std::string to_png(const measure::Field& field, const PictureOptions& options = {},
                   const std::vector<PictureLine>& edges = {});

}  // namespace patchwright::report
#pragma GCC visibility pop
