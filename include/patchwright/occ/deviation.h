// Two-sided deviation of two CAD models.
#pragma once

#include <patchwright/occ/cad_reference.h>

namespace patchwright::occ {

/// Distances of sample points on one model to the nearest point of the other, in millimetres.
struct Deviation {
    double max = 0.0;
    double rms = 0.0;
    double p95 = 0.0;
    double p99 = 0.0;
    geom::Vec3 at = geom::Vec3::Zero();  ///< where on the sampled model the maximum lies
    int face = -1;                       ///< its face there, counted as `inspect` lists them
    int samples = 0;
};

/// From `from`, sampled at about `samples` points, to `to`. Points where a face normal exists are
/// matched plainly to the nearest point, whatever its side.
Deviation measure_deviation(const CadReference& from, const CadReference& to, int samples,
                            const base::Progress& progress = {});

}  // namespace patchwright::occ
