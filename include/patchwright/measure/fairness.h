// Figures of how fair a limit surface and how even its isolines are.
#pragma once

#include <patchwright/mesh/cage.h>

#pragma GCC visibility push(default)
namespace patchwright::measure {

struct Fairness {
    /// Root of the mean over the area of the squared rate at which normal curvature along isolines
    /// changes with their arc length, over both families; times the squared diagonal, so that it
    /// has no unit: 0 for spheres and where isolines are circles or lines.
    double curvature_variation = 0.0;
    /// Root mean square of the cosine of the angle between isolines: 0 where they are orthogonal.
    double skew = 0.0;
    /// The smallest angle between isolines, radians in [0, pi/2].
    double least_angle_rad = 0.0;
    /// Root mean square of the logarithm (base 2) of the ratio of neighbouring faces' sizes along
    /// isolines: 0 where spacing is even.
    double uneven_spacing = 0.0;
};

/// From samples inside all quads of the cage.
/// @param samples  an edge, at least 3
Fairness measure_fairness(const mesh::Cage& cage, int samples = 4);

}  // namespace patchwright::measure
#pragma GCC visibility pop
