// Weights of a fit's steps, and how they change from one to the next.
#pragma once

#include <patchwright/mesh/topology.h>

#include <Eigen/Core>
#include <algorithm>
#include <set>

namespace patchwright::fit {

/// |A^T r| at which a solve for surfaces ends, relative to its start: their foot points are found
/// anew after each step, so that this is enough (decision 086).
inline constexpr double surface_residual = 1e-3;

class StepWeights {
  public:
    double fairness;                       ///< of the bending energy
    double tangential = first_tangential;  ///< of the tangential part of residuals
    Eigen::VectorXd damping;               ///< of control points, see StepOperator

    StepWeights(Eigen::Index control_points, double first_fairness)
        : fairness(first_fairness),
          damping(Eigen::VectorXd::Constant(control_points, first_damping)) {}

    /// After a step that is taken.
    void after_taken() {
        damping = (damping_decay * damping).cwiseMax(min_damping);
        tangential = std::max(tangential_factor * tangential, min_tangential);
        fairness *= fairness_factor;
    }
    /// A shorter step; false when it would be too short to matter.
    [[nodiscard]] bool after_refused() {
        if (tangential < 1.0) {
            tangential = 1.0;
            return true;
        }
        damping *= damping_growth;
        return damping.minCoeff() <= max_damping;
    }
    /// Whether a step was refused since the last one that was taken.
    [[nodiscard]] bool are_raised() const { return tangential >= 1.0; }
    /// A shorter step of these control points; false when theirs are too short already.
    [[nodiscard]] bool shorten_at(const std::set<mesh::VertexId>& control_points) {
        bool any = false;
        for (const mesh::VertexId v : control_points) {
            double& at = damping[v.value];
            any = any || at < most_local_damping;
            at = std::clamp(local_damping_growth * at, first_local_damping, most_local_damping);
        }
        return any;
    }

  private:
    // 1 is point distance, whose steps never make things worse but are short; 0 is tangent
    // distance. It falls from the first to the minimum, which keeps samples from drifting
    // (Pottmann, Leopoldseder, Hofer 2002).
    static constexpr double first_tangential = 0.3, min_tangential = 0.01, tangential_factor = 0.3;
    static constexpr double fairness_factor = 0.2;
    // Levenberg-Marquardt damping, relative to unit columns: raised until a step is taken, or so
    // high that no step of any length would help.
    static constexpr double first_damping = 1e-6, min_damping = 1e-9, max_damping = 10.0;
    static constexpr double damping_growth = 30.0, damping_decay = 0.2;
    // Where a step would invert faces: from half the way to a hundredth.
    static constexpr double first_local_damping = 1.0, most_local_damping = 100.0;
    static constexpr double local_damping_growth = 10.0;
};

}  // namespace patchwright::fit
