// Where the samples of a fit are and belong, and which of them are inverted.
#pragma once

#include "fit/loop/level_fit.h"
#include "fit/solve/regularisation.h"
#include "fit/solve/step_operator.h"

#include <functional>

namespace patchwright::fit {

/// Of the tolerance: points of the reference that are farther off become targets where any are
/// beyond it, so that the limit surface between the samples has the rest.
inline constexpr double reverse_target_share = 0.4;

/// Limit points of a control mesh, their targets, and how the residuals count.
struct Projection {
    geom::Points limit, target;
    SampleWeights weights;
    Distances distances;
    /// Of faces du x dv, not of unit length; of curves the chord from the previous to the next
    /// sample.
    geom::Points normals;
    /// Jacobian along the normal of the foot point (of curves: along the given curve), in parts of
    /// that of the given control points.
    Eigen::VectorXd jacobian_ratio;
    bool of_curves = false;

    /// Limit points with unit weights and without targets.
    Projection(const subd::LimitOperator& samples, const geom::Points& points);
    /// Sets `distances`.
    void sum_up();

    [[nodiscard]] bool is_nearly_inverted(Eigen::Index i) const;
    [[nodiscard]] bool is_inverted(Eigen::Index i) const { return jacobian_ratio[i] < 0.0; }

    /// Sum of squared distances, each times its squared weight.
    [[nodiscard]] double energy(const SampleWeights& by) const {
        return (limit - target).rowwise().squaredNorm().dot(by.weight.cwiseAbs2());
    }
};

/// The foot point of a limit point, but not on the far side of a thin part.
/// Around a rounded edge normals turn by half a circle within a short way; a nearest point whose
/// normal is across is on that edge, and the next one with the normal of the limit point may be far
/// from it. In a small fold normals point to the wrong side; the distance of that foot point tells.
/// @param normal  of the limit surface, unit
/// @param reach   foot points farther away are not accepted for their normal, millimetres
/// @param part    where the foot point is to lie (see SurfaceParts); null: anywhere
geom::FootPoint oriented_foot_point(const geom::ReferenceSurface& reference,
                                    const geom::Vec3& point,
                                    const std::optional<geom::Vec3>& normal, double reach,
                                    const std::vector<char>* part);

/// Weight of a sample: less where the normal of the foot point disagrees with the sample's, as on
/// the far side of a thin part or in a fold, and where the foot point has jumped.
/// @param last    the projection before, if any
/// @param cosine  of the angle between the two normals
double sample_weight(const Projection& p, const Projection* last, Eigen::Index row, double cosine,
                     double tolerance_mm);

/// What a step inverts.
struct Inversion {
    std::vector<std::size_t> sites;  ///< inverted or nearly inverted by it
    bool more = false;               ///< more samples are inverted than before
};

/// Samples count that turn, or whose foot points come to face the other way while they go farther
/// from these, as beyond an edge; on thin parts foot points change sides without that.
/// @param rows  first sample of each site, one more than sites
Inversion inverted_by_step(const std::vector<std::int32_t>& rows, const Projection& now,
                           const Projection& next);

}  // namespace patchwright::fit
