// A CAD model as reference surface: foot points on its trimmed faces, features from its edges.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/occ/cad_model.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace patchwright::occ {

struct SearchModel;  ///< defined in src/occ only

struct ReferenceOptions {
    double sharp_angle_rad = 0.349;  ///< dihedral deviation from flat above which an edge is sharp
    double deflection_rel = 2e-4;    ///< triangulation deflection, fraction of the diagonal
    /// How much farther (fraction of the diagonal) a point on the asked-for side may lie than the
    /// nearest one and still be preferred.
    double side_reach_rel = 2e-2;
    base::Progress progress;
};

/// Nearest points on the trimmed faces of a model: a box hierarchy over a triangulation gives the
/// candidates, Newton on the face's polynomials the foot point, the trim test and edge projections
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

    /// The same answer as foot_point(query, side), sooner when `last` is near it: for queries that
    /// advance along a curve or in small steps.
    /// @param last  an earlier answer of this reference
    [[nodiscard]] geom::FootPoint foot_point_from(
        const geom::FootPoint& last, const geom::Vec3& query,
        const std::optional<geom::Vec3>& side = std::nullopt) const;

    /// Foot points of many queries, on all threads; the same answers one by one.
    /// @param sides  empty, or one row a query: unit vectors; zero rows ask for no side
    /// @throw InvalidArgument when the numbers of rows differ or a query is not finite
    [[nodiscard]] std::vector<geom::FootPoint> foot_points(
        const geom::Points& queries, const geom::Points& sides = geom::Points(0, 3)) const;

    struct Curvature {
        /// Principal curvatures, least first, 1/mm; positive where the surface bends towards its
        /// outward normal: -1/r twice on a sphere.
        std::array<double, 2> value{0.0, 0.0};
        std::array<geom::Vec3, 2> direction{geom::Vec3::Zero(), geom::Vec3::Zero()};  ///< unit
    };
    /// Of the face at an answer's parameters; nothing where the surface is degenerate there.
    /// @throw InvalidArgument when the answer names no face of this reference
    [[nodiscard]] std::optional<Curvature> curvature(const geom::FootPoint& foot) const;

    /// Nearest point among the features of one kind; empty when the model has none.
    [[nodiscard]] std::optional<geom::FeaturePoint> feature_point(const geom::Vec3& query,
                                                                  geom::FeatureKind kind) const;
    [[nodiscard]] const geom::Features& features() const override;
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within = std::nullopt) const override;
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override;

    struct Sample {
        geom::Vec3 point, normal;
        int face;
        double weight;  ///< area that it stands for, mm^2; 0 on edges and vertices
    };
    /// About `count` points on the faces, half of them spread by area, half by how much the faces
    /// bend, at least a few a face; plus points on all edges and vertices. Deterministic.
    [[nodiscard]] std::vector<Sample> sample(int count) const;

    struct CurveSample {
        geom::Vec3 point;
        int curve;      ///< number among features().curves
        double weight;  ///< length that it stands for, mm
    };
    /// Points on all feature curves of one kind, evenly spaced by arc length, both ends included.
    /// @throw InvalidArgument when the spacing is not positive
    [[nodiscard]] std::vector<CurveSample> sample_curves(geom::FeatureKind kind,
                                                         double spacing_mm) const;

    /// For the sources of this room.
    [[nodiscard]] const SearchModel& search_model() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace patchwright::occ
