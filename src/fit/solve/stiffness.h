// What holds surfaces and curves back while they are fitted: bending, and the even lines of the
// cage they came from.
#pragma once

#include "fit/solve/step_operator.h"

#include <patchwright/mesh/topology.h>

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

/// Second derivatives at 2 x 2 places a face, or at 2 places a side for curves.
class FormStiffness {
  public:
    /// @param given  control points whose lines are to be kept
    /// @param slack  sliding by as much as a face is wide, or a side long, counts as much as
    /// missing
    ///               by this; 0: all may slide
    static FormStiffness of_surface(const mesh::Topology& topology, const geom::Points& given,
                                    double slack);
    /// Along curves only: what is across them counts nothing.
    /// @param sites  sides, see CurveSampling
    static FormStiffness of_curves(const mesh::Topology& topology,
                                   const std::vector<subd::Site>& sites, const geom::Points& given,
                                   double slack);

    [[nodiscard]] const subd::LimitOperator& rows() const { return rows_; }
    /// Holds a site (of fit::face_sites, or a side) that is about to fold closer to its given form.
    /// @param miss  by how many times the slack the fit misses now: sliding is to count as much
    void hold(std::size_t site, double miss);

    /// Around the normals, or along the tangents, that there are now.
    [[nodiscard]] Stiffness around(const geom::Points& points, double bending,
                                   double evenness) const;
    /// Of the second derivatives, as a step is to make them.
    [[nodiscard]] geom::Points changes(const geom::Points& points, const Stiffness& s) const;
    [[nodiscard]] double energy(const geom::Points& points, const Stiffness& s) const;

  private:
    FormStiffness(subd::LimitOperator rows, subd::LimitOperator places, const geom::Points& given,
                  Eigen::VectorXd evenness, bool of_curves);
    /// Unit normal or tangent of each row.
    [[nodiscard]] geom::Points directions(const geom::Points& points) const;
    /// What of a row only moves lines.
    [[nodiscard]] Eigen::RowVector3d sliding(const Stiffness& s, const Eigen::RowVector3d& row,
                                             Eigen::Index i) const;

    subd::LimitOperator rows_, places_;
    geom::Points given_;
    Eigen::VectorXd evenness_;     // of the rows
    std::vector<double> factors_;  // of the sites' evenness
    bool of_curves_;
};

}  // namespace patchwright::fit
