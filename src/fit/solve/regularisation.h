// What keeps surfaces and curves regular while they are fitted: bending energy, and tangential
// regularisation towards the parametrisation of the given cage.
#pragma once

#include "fit/solve/step_operator.h"

#include <patchwright/mesh/topology.h>

#include <vector>

namespace patchwright::fit {

/// How second derivatives count: with the weight of the bending energy, and their part in the
/// tangent plane, which changes the parametrisation but bends nothing, with the tangential weight
/// besides.
struct RegularisationWeights {
    SampleWeights rows;
    double bending = 0.0;
    Eigen::VectorXd tangential;
    /// How much of the given cage's part in the tangent plane is to be there, from 0 to 1.
    Eigen::VectorXd kept;
};

/// Second derivatives at 2 x 2 positions a face, or at 2 positions a side for curves.
class Regularisation {
  public:
    /// @param given  control points whose parametrisation is to be preserved
    /// @param scale  a tangential motion by the width of a face, or the length of a side, counts as
    ///               much as a distance of this from the reference; 0: no tangential
    ///               regularisation
    /// @param evens_lines  see FitOptions::Solver
    static Regularisation of_surface(const mesh::Topology& topology, const geom::Points& given,
                                     double scale, bool evens_lines);
    /// Tangential to curves only; the part across them has no weight.
    /// @param sites  sides, see CurveSampling
    static Regularisation of_curves(const mesh::Topology& topology,
                                    const std::vector<subd::Site>& sites, const geom::Points& given,
                                    double scale);

    [[nodiscard]] const subd::LimitOperator& rows() const { return rows_; }
    /// Makes the parametrisation of a site even in place of the given one, which is folded there.
    /// @param scale  in place of that of of_surface() there, if larger
    void even_out(std::size_t site, double scale);

    /// For the normals or tangents at these control points.
    [[nodiscard]] RegularisationWeights weights_at(const geom::Points& points, double bending,
                                                   double tangential) const;
    /// Changes of the second derivatives that a step is to make.
    [[nodiscard]] geom::Points changes(const geom::Points& points,
                                       const RegularisationWeights& s) const;
    [[nodiscard]] double energy(const geom::Points& points, const RegularisationWeights& s) const;

  private:
    Regularisation(subd::LimitOperator rows, subd::LimitOperator positions,
                   const geom::Points& given, Eigen::VectorXd tangential, double scale,
                   bool of_curves, bool evens_lines);
    /// Unit normal or tangent of each row.
    [[nodiscard]] geom::Points directions(const geom::Points& points) const;
    /// The part of a row that changes only the parametrisation.
    [[nodiscard]] Eigen::RowVector3d tangential_part(const RegularisationWeights& s,
                                                     const Eigen::RowVector3d& row,
                                                     Eigen::Index i) const;

    subd::LimitOperator rows_, positions_;
    geom::Points given_;
    Eigen::VectorXd tangential_;   // weights of the rows
    double scale_;                 // of these weights
    std::vector<double> factors_;  // of the sites, on tangential_
    bool of_curves_, evens_lines_;
};

}  // namespace patchwright::fit
