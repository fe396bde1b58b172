// Where the samples of a fit are and belong, and which of them fold.
#pragma once

#include "fit/loop/level_fit.h"
#include "fit/solve/step_operator.h"
#include "fit/solve/stiffness.h"

#include <functional>

namespace patchwright::fit {

/// Limit points of a control mesh, where they should be, and how their residuals count.
struct Projection {
    geom::Points limit, target;
    SampleWeights weights;
    Distances distances;
    /// Of faces du x dv, of curves the way from the sample before to the next one.
    geom::Points sense;
    /// How much of that there is along the normal of the foot point, or along the given curve, of
    /// what there was.
    Eigen::VectorXd extent;
    bool of_curves = false;

    /// About to fold.
    [[nodiscard]] bool is_thin(Eigen::Index i) const;
    [[nodiscard]] bool folds(Eigen::Index i) const { return extent[i] < 0.0; }

    /// Of the distances, as `weights` count them.
    [[nodiscard]] double energy(const SampleWeights& by) const {
        return (limit - target).rowwise().squaredNorm().dot(by.weight.cwiseAbs2());
    }
};

/// Sums up the distances.
Projection finished(Projection p);

/// Weight of a sample: less where the foot point faces elsewhere than the sample, as on the wrong
/// side of something thin or in a fold, and where it has jumped: not what it should be drawn to.
/// @param last    projection before, if any
/// @param cosine  of the angle between the normals of both
double trust(const Projection& p, const Projection* last, Eigen::Index row, double cosine,
             double tolerance_mm);

/// Holds sites that fold after a step, or are about to, closer to their given form.
/// @param rows      first sample of each site, one more than sites
/// @param slack_mm  of the form, see FormStiffness
/// @param may_hold  for the samples of a site: whether its given form is worth keeping
/// @return whether there are more folds than before
bool hold_folds(FormStiffness& form, const std::vector<std::int32_t>& rows, const Projection& now,
                const Projection& next, double slack_mm,
                const std::function<bool(std::int32_t first, std::int32_t end)>& may_hold);

}  // namespace patchwright::fit
