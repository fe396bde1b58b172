// Samples the limit surface of one level and projects the samples onto the reference.
#pragma once

#include "fit/loop/projection.h"
#include "fit/match/path_alignment.h"
#include "fit/match/surface_parts.h"
#include "fit/match/vertex_samples.h"
#include "measure/limit_search.h"

#include <functional>
#include <optional>

namespace patchwright::fit {

/// The features that the sharp edges of a cage belong to.
/// @param curve_points  limit points of the sites of `curves`
FeatureMatch match_cage(const mesh::Cage& cage, const CurveSampling& curves,
                        const geom::Points& curve_points, const geom::ReferenceSurface& reference,
                        const FitOptions& options);

/// Limit points of the sites of `curves`.
geom::Points curve_points(const mesh::Cage& cage, const CurveSampling& curves,
                          int samples_per_edge);

/// Everything that is sampled on a level, at any positions of its control points.
class Projector {
  public:
    /// @param given       control points to which Jacobian ratios are relative
    /// @param foot_reach  see oriented_foot_point
    /// @param poll        called from this thread between batches of foot points; may throw
    /// @pre `reference` and `options` outlive it; it stays where it is
    Projector(const mesh::Cage& given, const geom::ReferenceSurface& reference,
              const FitOptions& options, double foot_reach, std::function<void()> poll);
    Projector(const Projector&) = delete;
    Projector& operator=(const Projector&) = delete;

    [[nodiscard]] const CurveSampling& curves() const { return curves_; }
    [[nodiscard]] const FeatureMatch& match() const { return match_; }
    /// Of the samples of curves and of faces; rows are those of the projections.
    [[nodiscard]] const subd::LimitOperator& curve_samples() const { return curve_; }
    [[nodiscard]] const subd::LimitOperator& face_samples() const { return surface_; }

    [[nodiscard]] Projection project_curves(const geom::Points& points) const;
    /// @param last  the projection before, if any
    [[nodiscard]] Projection project_surface(const geom::Points& points,
                                             const Projection* last) const;

    /// Limit points nearest to points of the reference.
    [[nodiscard]] std::vector<measure::NearLimit> nearest(const geom::Points& points,
                                                          const std::vector<geom::Vec3>& queries);
    /// Points of the reference that become targets of the samples nearest to them; see nearest().
    void set_reverse_targets(std::vector<geom::Vec3> targets) {
        reverse_targets_ = std::move(targets);
    }

    /// Whether samples of a face oppose the reference already on the given control points: its
    /// given shape is not one to preserve.
    [[nodiscard]] bool is_inverted_when_given(std::int32_t first, std::int32_t end) const;
    /// Whether normals of the given cage's samples point to both sides.
    [[nodiscard]] bool is_folded_when_given(std::int32_t first, std::int32_t end) const;

  private:
    /// A chain's path and the rows of its samples, in their order along it.
    struct AlignedChain {
        PathAlignment alignment;
        std::vector<Eigen::Index> rows;
    };

    /// @param on_path  by row, for those of chains with a path
    void project_curve_site(std::size_t site, const std::vector<geom::FeaturePoint>& on_path,
                            Projection& p) const;
    void add_reverse_targets(const geom::Points& points, Projection& p) const;
    /// @param along  whether the residual should lie along the direction, else across it
    void set_direction(Projection& p, Eigen::Index row, const geom::Vec3& direction,
                       bool along) const;
    /// How far foot points beyond a fold are accepted: so many sizes of the sample's given face.
    void set_reach(double most);
    void set_parts();
    /// `body(first, end)` for all of `count`, on any thread, with calls of poll_ in between.
    template <class Body>
    void in_batches(std::size_t count, std::size_t grain, const Body& body) const;

    std::shared_ptr<const mesh::Topology> topology_;
    const geom::ReferenceSurface& reference_;
    const FitOptions& options_;
    /// Of the samples of surface_ on faces, see oriented_foot_point.
    Eigen::VectorXd reach_;
    std::vector<const std::vector<char>*> part_of_row_;
    std::function<void()> poll_;
    CurveSampling curves_;
    geom::Points given_curves_;  // of the samples of curves_
    FeatureMatch match_;
    SurfaceParts parts_;
    VertexSamples vertices_;
    subd::LimitOperator surface_, curve_;
    std::vector<AlignedChain> alignments_;
    geom::Points given_limit_, given_normals_;  // of the samples of surface_
    std::optional<measure::LimitSearch> search_;
    std::vector<geom::Vec3> reverse_targets_;
};

}  // namespace patchwright::fit
