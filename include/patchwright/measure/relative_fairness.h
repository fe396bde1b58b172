// How fair a surface is by the standard of the one that it was made from: whether its normals and
// curvatures follow those of the other one, and whether it turns where the other one does not.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>

#include <algorithm>

#pragma GCC visibility push(default)
namespace patchwright::measure {

/// Of values that stand for equal areas.
struct Distribution {
    double rms = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
    geom::Vec3 at = geom::Vec3::Zero();  ///< where the largest one is
};

/// Points beside the input's sharp and free edges are left out, and those that have no counterpart
/// on the input.
struct RelativeFairness {
    int samples = 0;                ///< that count
    int left_out = 0;               ///< beside edges
    int unmatched = 0;              ///< without a tangent plane, or far from the input
    Distribution normal_angle_rad;  ///< between the tangent planes of output and input, 0 to pi/2
    /// |mean curvature of the output - that of the input| times the input's diagonal; mean
    /// curvature is half the sum of the principal ones.
    Distribution curvature_difference;
    /// Along lines of constant parameter of the output's untrimmed faces: how often the input's
    /// normal curvature in their direction changes its sign, and how often the output's does
    /// beyond that. The surface must turn by 0.05 degrees between two changes.
    int lines = 0, inflections = 0;
    int extra_inflections = 0;  ///< negative where the output has fewer
};

struct RelativeFairnessOptions {
    /// Lines take most of the time, some 500 foot points each: fewer samples have fewer lines.
    static constexpr int samples_a_line = 83, most_lines = 240;
    int samples = 20000;  ///< on the output's faces, evenly by area
    /// Half of them along each parameter.
    int lines = std::min(samples / samples_a_line, most_lines);
    base::Progress progress;
};

/// @throw InvalidArgument when there are no samples, or a negative number of lines
/// @throw Cancelled or TimeLimitReached from the progress callback
RelativeFairness measure_relative_fairness(const geom::ModelSurface& output,
                                           const geom::ModelSurface& input,
                                           const RelativeFairnessOptions& options = {});

}  // namespace patchwright::measure
#pragma GCC visibility pop
