// A CAD model as reference surface: foot points on its trimmed faces, features from its edges.
#pragma once

#include <patchwright/geom/model_surface.h>
#include <patchwright/occ/cad_model.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::occ {

struct SearchModel;  ///< defined in src/occ only

/// What finds nearest points on faces; feature curves have their own search.
enum class FootPoints {
    Search,  ///< the search of this library
    Kernel   ///< the CAD kernel's extrema, much slower: another opinion; it sees no kinks inside
             ///< faces
};

struct ReferenceOptions {
    /// Dihedral deviation from flat above which an edge is sharp.
    double sharp_angle_rad = geom::default_sharp_angle_rad;
    double deflection_rel = 2e-4;  ///< triangulation deflection, fraction of the diagonal
    /// How much farther (fraction of the diagonal) a point on the asked-for side may lie than the
    /// nearest one and still be preferred.
    double side_reach_rel = 2e-2;
    FootPoints foot_points = FootPoints::Search;
    std::optional<double> size_mm;  ///< see CadReference::size(); none: the diagonal
    base::Progress progress;
};

/// Nearest points on the trimmed faces of a model: a box hierarchy over a triangulation gives the
/// candidates, Newton on the face's polynomials the foot point, the trim test and edge projections
/// the rest. Keeps the model alive.
class CadReference final : public geom::ModelSurface {
  public:
    /// @throw InputError when no face can be triangulated
    explicit CadReference(const CadModel& model, const ReferenceOptions& options = {});
    ~CadReference() override;
    CadReference(CadReference&&) noexcept;
    CadReference& operator=(CadReference&&) noexcept;

    [[nodiscard]] geom::Box3 bounds() const override;
    [[nodiscard]] double size() const override;
    [[nodiscard]] geom::FootPoint foot_point(
        const geom::Vec3& query,
        const std::optional<geom::Vec3>& side = std::nullopt) const override;

    [[nodiscard]] geom::FootPoint foot_point_on(
        const std::vector<char>& faces, const geom::Vec3& query,
        const std::optional<geom::Vec3>& side = std::nullopt) const override;
    [[nodiscard]] std::vector<geom::FaceBorder> face_borders() const override;

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

    [[nodiscard]] std::optional<geom::Curvature> curvature(
        const geom::FootPoint& foot) const override;
    [[nodiscard]] std::optional<geom::FeaturePoint> feature_point(
        const geom::Vec3& query, geom::FeatureKind kind) const override;
    [[nodiscard]] const geom::Features& features() const override;
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within = std::nullopt) const override;
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override;

    /// At least a few samples a face; points on all edges and vertices.
    [[nodiscard]] std::vector<geom::SurfaceSample> sample(int count) const override;
    [[nodiscard]] std::vector<geom::SurfacePiece> pieces() const override;
    [[nodiscard]] geom::FootPoint point_on_face(int face, const Eigen::Vector2d& uv) const override;

    [[nodiscard]] geom::SurfaceMesh surface_mesh(double deflection_mm) const override;
    [[nodiscard]] std::vector<std::string> face_names() const override;
    [[nodiscard]] bool has_cad_faces() const override { return true; }

    /// For the sources of this room.
    [[nodiscard]] const SearchModel& search_model() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Connected faces of a model, as a surface of their own. Where bodies overlap or touch,
/// the nearest point among all of them may lie on the wrong one.
struct BodyReference {
    std::vector<int> faces;  ///< of the model
    std::shared_ptr<const CadReference> surface;
};

/// The bodies of a model, each as a reference of its own, but for those that cannot be
/// triangulated.
std::vector<BodyReference> body_references(const CadModel& model,
                                           const ReferenceOptions& options = {});

}  // namespace patchwright::occ
#pragma GCC visibility pop
