// An upper bound of how far the points of one model are from another.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/occ/cad_reference.h>

namespace patchwright::occ {

struct DeviationBoundOptions {
    double at_least = 0.0;   ///< a distance that was found; the bound is refined towards it
    double slack_rel = 0.1;  ///< how much more than that is near enough
    double slack_mm = 0.0;   ///< the same in millimetres; the larger counts
    int max_refinements = 100000;
    base::Progress progress;
};

/// No point of `from` is farther from `to` than this.
/// Over a triangle whose corners have feet on `to`, the distance to the triangle of the feet is a
/// convex function, so nowhere larger than at a corner; to that come the distances from both
/// triangles to their surfaces. Triangles with the largest bound are quartered on the surface until
/// what is added is small. The distances from triangles to surfaces are seen at three or four
/// points and taken half as large again.
/// (Compare Tang, Lee, Kim, Interactive Hausdorff distance computation for general polygonal
/// models, 2009.)
double deviation_bound(const CadReference& from, const CadReference& to,
                       const DeviationBoundOptions& options);

}  // namespace patchwright::occ
