// Fields as files for ParaView (VTP) and for viewers and modellers (GLB).
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/measure/field.h>

#include <string>

#pragma GCC visibility push(default)
namespace patchwright::report {

/// VTK's XML for polygons: triangles, then feature lines, in this unit. Point arrays: Normals,
/// "curvature" (1/unit), and where there is another model "deviation", "normal angle [degrees]",
/// "other curvature" (of its nearest point); cell array "face", -1 for lines.
std::string to_vtp(const measure::Field& field, base::LengthUnit unit);

/// Binary glTF in metres, with the model's z up: triangles, coloured from blue (deviation 0) to red
/// (the scale or more), grey where there is no other model, and feature lines. The values are in
/// the custom attributes _DEVIATION, _NORMAL_ANGLE, _CURVATURE, _OTHER_CURVATURE, in mm and
/// degrees.
/// @param scale_mm  deviation that is red; positive
std::string to_glb(const measure::Field& field, double scale_mm);

}  // namespace patchwright::report
#pragma GCC visibility pop
