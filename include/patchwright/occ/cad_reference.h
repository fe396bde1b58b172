// A CAD model as reference surface: foot points on its trimmed faces, features from its edges.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/occ/cad_model.h>

#include <memory>

namespace patchwright::occ {

struct ReferenceOptions {
    double sharp_angle_rad = 0.349;  ///< dihedral deviation from flat above which an edge is sharp
    double deflection_rel = 2e-4;    ///< triangulation deflection, fraction of the diagonal
    /// How much farther (fraction of the diagonal) a point on the asked-for side may lie than the
    /// nearest one and still be preferred.
    double side_reach_rel = 2e-2;
    base::Progress progress;
};

/// Nearest points on the trimmed faces of a model: a box hierarchy over a triangulation gives the
/// candidates, Newton on the kernel's surface the foot point, the trim test and edge projections
/// the rest. Keeps the model alive.
class CadReference final : public geom::ReferenceSurface {
  public:
    /// @throw InputError when no face can be triangulated
    explicit CadReference(const CadModel& model, const ReferenceOptions& options = {});
    ~CadReference() override;
    CadReference(CadReference&&) noexcept;
    CadReference& operator=(CadReference&&) noexcept;

    [[nodiscard]] geom::Box3 bounds() const override;
    [[nodiscard]] geom::FootPoint foot_point(
        const geom::Vec3& query,
        const std::optional<geom::Vec3>& side = std::nullopt) const override;
    [[nodiscard]] std::optional<geom::FeaturePoint> feature_point(
        const geom::Vec3& query, geom::FeatureKind kind) const override;
    [[nodiscard]] const geom::Features& features() const override;
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within = std::nullopt) const override;
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override;

    struct Sample {
        geom::Vec3 point, normal;
        int face;
    };
    /// About `count` points on the faces, in number by area but at least a few a face, plus points
    /// on all edges and vertices. Deterministic.
    [[nodiscard]] std::vector<Sample> sample(int count) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace patchwright::occ
