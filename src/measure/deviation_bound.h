// An upper bound of how far the points of one model are from another.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>

namespace patchwright::measure {

struct DeviationBoundOptions {
    double at_least = 0.0;   ///< a distance that was found; the bound is refined towards it
    double slack_rel = 0.1;  ///< how much more than that is near enough
    double slack_mm = 0.0;   ///< the same in millimetres; the larger counts
    int max_refinements = 20000;
    base::Progress progress;
};

/// No point of `from` is farther from `to` than this.
/// The way from a point to its foot is looked at in the corners of every triangle of the mesh and
/// at four points between. Interpolated between the corners its length is nowhere larger than
/// there; how far it is from that at the four points is taken half as large again for what lies
/// between them, and triangles with the largest bound are quartered on the surface until it is
/// small. What a triangle at a curved border leaves out counts with its width. So this is a bound
/// for shapes that do not bend in wholly new ways between samples, not a proof. (Compare Tang, Lee,
/// Kim, Interactive Hausdorff distance computation for general polygonal models, 2009, for
/// quartering.)
double deviation_bound(const geom::ModelSurface& from, const geom::ModelSurface& to,
                       const DeviationBoundOptions& options);

}  // namespace patchwright::measure
