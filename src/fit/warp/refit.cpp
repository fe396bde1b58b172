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

bool meets(const FitResult& fitted) {
    return fitted.within_tolerance && fitted.levels.front().folded == 0;
}

/// Folds are looked for within the tolerance only: of what misses, the first one stays unless
/// another is clearly nearer.
bool better(const FitResult& a, const FitResult& b) {
    constexpr double clearly = 0.9;
    if (a.within_tolerance != b.within_tolerance) return a.within_tolerance;
    const FitLevel &left = a.levels.front(), &right = b.levels.front();
    return a.within_tolerance ? left.folded < right.folded
                              : left.largest() < clearly * right.largest();
}

}  // namespace

RefitResult refit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const FitOptions& given_options, const ModelChange* change) {
    FitOptions options = given_options;
    options.max_levels = 0;
    options.crease_rule.reset();
    options.solver.tangential_scale_rel = tangential_scale_rel;
    const bool away = faces_away(cage, reference);
    const TurnedReference turned(reference);
    const geom::ReferenceSurface& facing = away ? turned : reference;
    RefitResult best = refit_from(cage, facing, options, usual_cells, change);
    std::vector<int> others{most_cells};
    if (change != nullptr) others.insert(others.begin(), usual_cells);
    for (const int cells : others) {
        if (meets(best.fit) || best.fit.stopped_by_time_limit) break;
        try {
            RefitResult other = refit_from(cage, facing, options, cells, nullptr);
            if (better(other.fit, best.fit)) best = std::move(other);
        } catch (const base::TimeLimitReached&) {
            best.fit.stopped_by_time_limit = true;
        }
    }
    best.fit.faces_away = away;
    return best;
}

}  // namespace patchwright::fit
