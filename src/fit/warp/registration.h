// Carries a fitted cage over to a shape that has changed, before it is fitted again.
#pragma once

#include <patchwright/fit/refit.h>

namespace patchwright::fit {

struct Registration {
    mesh::Cage cage;
    std::vector<WarpStage> stages;  ///< none where the cage lies on the shape as it is
};

/// Moves the control points by an affine map and then by B-spline lattices that become finer, each
/// by Gauss-Newton steps: samples of the limit surface go to the tangent planes at their foot
/// points on the side that they face, corners between creases and borders to corners of the
/// reference, one to one, chains between such corners to the curves between these, by shares of
/// their arc length.
/// Where it is known how the model has changed, samples go where their foot points on the earlier
/// model have gone in place of that.
/// @param finest  cells of the finest lattice along the longest side of the cage's box
/// @param change  null: not known
/// @pre the reference faces as the cage does
Registration registered(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                        const FitOptions& options, int finest, const ModelChange* change = nullptr);

}  // namespace patchwright::fit
