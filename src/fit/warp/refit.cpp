#include "fit/loop/facing.h"
#include "fit/warp/registration.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/refit.h>

namespace patchwright::fit {

namespace {

/// Cells of the finest lattices that are tried, one after the other.
constexpr int usual_cells = 8, most_cells = 16;
/// See FitOptions::Solver. Lines are held less than in fits: held as much, narrow faces fold
/// (decision 070: of 50 wings that differ in five ways from the one fitted, 14 miss with the scale
/// of fits, two with this).
constexpr double tangential_scale_rel = 0.03;

/// A result with the folds that count.
struct Trial {
    RefitResult result;
    int folded = 0;

    [[nodiscard]] bool meets() const { return result.fit.within_tolerance && folded == 0; }
};

Trial refit_from(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                 const RefitOptions& options, int cells, const ModelChange* change) {
    Registration carried = registered(cage, reference, options.fit, cells, change);
    Trial trial;
    RefitResult& result = trial.result;
    result.stages = std::move(carried.stages);
    result.carried_mm = (carried.cage.points - cage.points).rowwise().norm().maxCoeff();
    result.fit = fit(carried.cage, reference, options.fit);
    trial.folded = result.fit.within_tolerance && options.count_folds
                       ? options.count_folds(result.fit.cage)
                       : result.fit.levels.front().folded;
    return trial;
}

/// Folds are looked for within the tolerance only: of what misses, the first one stays unless
/// another is clearly nearer.
bool better(const Trial& a, const Trial& b) {
    constexpr double clearly = 0.9;
    const FitResult &left = a.result.fit, &right = b.result.fit;
    if (left.within_tolerance != right.within_tolerance) return left.within_tolerance;
    return left.within_tolerance
               ? a.folded < b.folded
               : left.levels.front().largest() < clearly * right.levels.front().largest();
}

}  // namespace

RefitResult refit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const RefitOptions& given_options) {
    RefitOptions options = given_options;
    options.fit.max_levels = 0;
    options.fit.crease_rule.reset();
    options.fit.solver.tangential_scale_rel = tangential_scale_rel;
    const bool away = faces_away(cage, reference);
    const TurnedReference turned(reference);
    const geom::ReferenceSurface& facing = away ? turned : reference;
    Trial best = refit_from(cage, facing, options, usual_cells, options.change);
    FitResult& fitted = best.result.fit;
    std::vector<int> others{most_cells};
    if (options.change != nullptr) others.insert(others.begin(), usual_cells);
    for (const int cells : others) {
        if (best.meets() || fitted.stopped_by_time_limit) break;
        try {
            Trial other = refit_from(cage, facing, options, cells, nullptr);
            if (better(other, best)) best = std::move(other);
        } catch (const base::TimeLimitReached&) {
            fitted.stopped_by_time_limit = true;
        }
    }
    fitted.faces_away = away;
    return std::move(best.result);
}

}  // namespace patchwright::fit
