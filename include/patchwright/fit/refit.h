// Fits a fitted cage again to a shape that has changed, with the same topology.
#pragma once

#include <patchwright/fit/fit.h>
#include <patchwright/fit/model_change.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// What one stage of the registration reached; distances are those of samples of the limit surface
/// from their foot points, or from where a known change puts them.
struct WarpStage {
    int cells = 0;  ///< of the lattice, along the longest side; 0: an affine map
    int steps = 0;
    double rms_mm = 0.0, max_mm = 0.0;
    double seconds = 0.0;
};

struct RefitOptions {
    /// Levels, refinement, crease rule and how lines are held (FitOptions::Solver) have no effect.
    FitOptions fit;
    /// To the reference, from what the cage was fitted to; null: not known.
    const ModelChange* change = nullptr;
};

struct RefitResult {
    FitResult fit;
    /// Of the registration that the fit started from.
    std::vector<WarpStage> stages;
    /// Largest displacement of a control point by the registration, millimetres.
    double carried_mm = 0.0;
};

/// Carries the cage to the reference by a registration (affine, then lattices of B-splines that
/// become finer), then fits it without refining it: the topology stays, with its names, creases and
/// tags. Pinned control points do not move. Where the change is known, the registration follows it.
/// @throw as fit()
RefitResult refit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const RefitOptions& options = {});

}  // namespace patchwright::fit
#pragma GCC visibility pop
