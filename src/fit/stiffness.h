// What holds a surface back while it is fitted: bending, and the even lines of the cage it came
// from.
#pragma once

#include "fit/step_operator.h"

#include <patchwright/mesh/topology.h>

#include <functional>
#include <vector>

namespace patchwright::fit {

/// How second derivatives count: all of them with the bending's weight, and what lies in the
/// surface, where it makes lines uneven but bends nothing, with the evenness' weight as far as it
/// is not the given cage's.
struct Stiffness {
    SampleWeights rows;
    double bending = 0.0;
    Eigen::VectorXd evenness;
};

/// Second derivatives at 2 x 2 places a face.
class SurfaceStiffness {
  public:
    /// @param given  control points whose lines are to be kept
    /// @param slack  sliding by as much as a face is wide counts as much as missing by this; 0: all
    ///               may slide
    SurfaceStiffness(const mesh::Topology& topology, const geom::Points& given, double slack);

    [[nodiscard]] const subd::LimitOperator& rows() const { return rows_; }
    /// Holds sites (fit::face_sites) that are about to fold closer to their given form. Whether
    /// there were any that could be.
    bool stiffen(const std::function<bool(std::size_t site)>& folds);

    /// Around the normals that the surface has now.
    [[nodiscard]] Stiffness around(const geom::Points& points, double bending,
                                   double evenness) const;
    /// Of the second derivatives, as a step is to make them.
    [[nodiscard]] geom::Points changes(const geom::Points& points, const Stiffness& s) const;
    [[nodiscard]] double energy(const geom::Points& points, const Stiffness& s) const;

  private:
    subd::LimitOperator rows_, places_;
    geom::Points given_;
    Eigen::VectorXd evenness_;       // of the rows
    std::vector<double> stiffened_;  // by site: factors that evenness_ has got
};

}  // namespace patchwright::fit
