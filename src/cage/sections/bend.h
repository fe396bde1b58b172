// Curves across which a model is sharp, or smooth but bends.
#pragma once

#include <patchwright/geom/features.h>

namespace patchwright::cage {

/// Whether a cage needs a crease along a curve: where the model is sharp, and where it bends so
/// much that smooth faces would round it off by more than the tolerance. A parabola over one
/// interval of width w leaves a corner of angle a by a w / 8.
/// @param width_mm  of the cage's faces, across the curve, at most
inline bool needs_crease(const geom::FeatureCurve& curve, double width_mm, double tolerance_mm) {
    if (curve.kind != geom::FeatureKind::Smooth) return curve.kind == geom::FeatureKind::Sharp;
    const double bend = curve.greatest_angle_rad;
    return bend > geom::least_bend_rad && bend * width_mm / 8.0 > tolerance_mm;
}

}  // namespace patchwright::cage
