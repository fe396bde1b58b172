// How the patches of a set meet, measured on their surfaces without the CAD kernel.
#pragma once

#include <patchwright/patch/patch_set.h>

#include <vector>

namespace patchwright::test {

struct Joint {
    int edge = -1;
    double gap = 0.0;   ///< largest distance of the two surfaces and the edge's curve
    double kink = 0.0;  ///< largest angle between the normals, radians
    double at = 0.0;    ///< share of the edge where the kink is
    bool flat = false;  ///< a surface without a normal was met
    bool crease = false;
};

/// One a shared edge. Samples are `spans` equal steps a unit of parameter, and denser towards both
/// ends.
std::vector<Joint> measure_joints(const patch::PatchSet& set, int spans = 8);

/// Parameter of side i (v low, u high, v high, u low) at s from its start, counter-clockwise.
Eigen::Vector2d on_side(const geom::BsplineSurface& surface, std::size_t side, double s);

}  // namespace patchwright::test
