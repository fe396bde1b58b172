#include "fit/loop/facing.h"
#include "fit/warp/registration.h"

#include <patchwright/fit/refit.h>

namespace patchwright::fit {

namespace {

/// Of the finest lattice, along the longest side of the cage's box.
constexpr int finest_cells = 8;
/// See FitOptions::Solver. The lines of a fitted cage are where they are to stay (decision 090).
constexpr double tangential_scale_rel = 0.5;

}  // namespace

RefitResult refit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const RefitOptions& options) {
    FitOptions fitting = options.fit;
    fitting.max_levels = 0;
    fitting.crease_rule.reset();
    fitting.solver.tangential_scale_rel = tangential_scale_rel;
    fitting.solver.evens_lines = false;
    const bool away = faces_away(cage, reference);
    const TurnedReference turned(reference);
    const geom::ReferenceSurface& facing = away ? turned : reference;
    Registration carried = registered(cage, facing, fitting, finest_cells, options.change);
    RefitResult result{
        .stages = std::move(carried.stages),
        .carried_mm = (carried.cage.points - cage.points).rowwise().norm().maxCoeff()};
    result.fit = fit(carried.cage, facing, fitting);
    result.fit.faces_away = away;
    return result;
}

}  // namespace patchwright::fit
