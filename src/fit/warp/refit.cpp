#include "fit/loop/facing.h"
#include "fit/warp/registration.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/refit.h>

namespace patchwright::fit {

namespace {

/// Cells of the finest lattices that are tried, one after the other.
constexpr int usual_cells = 8, most_cells = 16;
/// See FitOptions::Solver. Lines of a fitted cage lie where they are to stay, and the registration
/// has moved them smoothly; what slides folds narrow faces (decision 070: of 50 wings that differ
/// in five ways from the one fitted, 14 miss with the scale of fits, two with this).
constexpr double tangential_scale_rel = 0.03;

RefitResult refit_from(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                       const FitOptions& options, int cells, const ModelChange* change) {
    Registration carried = registered(cage, reference, options, cells, change);
    RefitResult result;
    result.stages = std::move(carried.stages);
    result.carried_mm = (carried.cage.points - cage.points).rowwise().norm().maxCoeff();
    result.fit = fit(carried.cage, reference, options);
    return result;
}

}  // namespace

RefitResult refit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const FitOptions& given_options, const ModelChange* change) {
    FitOptions options = given_options;
    options.max_levels = 0;
    options.solver.tangential_scale_rel = tangential_scale_rel;
    const bool away = faces_away(cage, reference);
    const TurnedReference turned(reference);
    const geom::ReferenceSurface& facing = away ? turned : reference;
    RefitResult best = refit_from(cage, facing, options, usual_cells, change);
    if (!best.fit.within_tolerance && !best.fit.stopped_by_time_limit) {
        try {
            RefitResult finer = refit_from(cage, facing, options, most_cells, change);
            if (finer.fit.levels.front().largest() < best.fit.levels.front().largest())
                best = std::move(finer);
        } catch (const base::TimeLimitReached&) {
            best.fit.stopped_by_time_limit = true;
        }
    }
    best.fit.faces_away = away;
    return best;
}

}  // namespace patchwright::fit
