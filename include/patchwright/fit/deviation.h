// Statistics of distances between two shapes.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::fit {

/// Distances of sample points on one shape to the nearest point of another, in millimetres.
struct Deviation {
    double max = 0.0;
    double rms = 0.0;
    double p95 = 0.0;
    double p99 = 0.0;
    geom::Vec3 at = geom::Vec3::Zero();  ///< where on the sampled shape the maximum lies
    int face = -1;                       ///< the sampled shape's face there; -1: no samples
    int samples = 0;
};

struct DistanceSample {
    geom::Vec3 point;
    int face;
    double distance;
};

/// Percentiles are the smallest distances that at least that share of the samples does not exceed.
Deviation deviation_statistics(const std::vector<DistanceSample>& samples);

}  // namespace patchwright::fit
