// Samples that tie single vertices of creases and borders to their places on features.
#pragma once

#include "fit/loop/projection.h"
#include "fit/match/feature_match.h"

#include <optional>

namespace patchwright::fit {

/// Parameters of sites on curves: side_sets(n), then corner_sets().
std::vector<subd::ParameterSet> curve_sets(int n);
/// Of sites on faces and curves: interior_grid(n), then curve_sets(n).
std::vector<subd::ParameterSet> surface_sets(int n);

/// The ends of creases within the surface (darts), and vertices where a curve turns sharply. A dart
/// moves its own limit point and the last two edges of its crease, and so do the points of the
/// surface around it: samples ask all of them to keep the crease where its curve is.
class VertexSamples {
  public:
    /// @pre `match` and `reference` outlive it
    VertexSamples(const mesh::Topology& topology, const CurveSampling& curves,
                  const FeatureMatch& match, const geom::ReferenceSurface& reference);

    /// The sites of curves, then those of the vertices; for use with curve_sets().
    [[nodiscard]] std::vector<subd::Site> after_curves(std::vector<subd::Site> sites) const;
    /// The sites of faces, then darts and the last edges before them; for use with surface_sets().
    [[nodiscard]] std::vector<subd::Site> after_faces(std::vector<subd::Site> sites) const;
    /// Samples before those of vertices.
    [[nodiscard]] Eigen::Index rows_before(const subd::LimitOperator& samples,
                                           bool of_curves) const;
    /// Targets and weights of the samples of these sites.
    void project(const subd::LimitOperator& samples, Projection& p) const;

  private:
    struct VertexSample {
        subd::Site site;                  ///< for use with curve_sets()
        int chain = -1;                   ///< the crease, whose path its points belong to
        std::optional<geom::Vec3> place;  ///< of a vertex; none: along an edge
    };
    [[nodiscard]] const std::vector<VertexSample>& samples_of(bool of_curves) const {
        return of_curves ? on_curves_ : on_faces_;
    }

    const FeatureMatch& match_;
    const geom::ReferenceSurface& reference_;
    std::vector<VertexSample> on_curves_;  ///< darts and turns
    std::vector<VertexSample> on_faces_;   ///< darts, then their last edges
};

}  // namespace patchwright::fit
