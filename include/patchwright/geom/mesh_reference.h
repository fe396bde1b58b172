// A triangle mesh as reference surface, without a CAD kernel.
#pragma once

#include <patchwright/geom/model_surface.h>
#include <patchwright/geom/triangle_mesh.h>

#include <memory>

#pragma GCC visibility push(default)
namespace patchwright::geom {

struct MeshReferenceOptions {
    /// Angle between neighbouring triangles above which their side is sharp: more than what the
    /// triangles of a rounded surface make, less than an edge.
    double sharp_angle_rad = 0.611;
    /// How much farther (fraction of the diagonal) a point on the asked-for side may lie than the
    /// nearest one and still be preferred.
    double side_reach_rel = 2e-2;
};

/// Nearest points are on the triangles as they are. Normals are blended between the points'
/// (weighted by angle, each side of a feature on its own), curvature comes from how they turn.
/// Features are chains of sharp and of free sides between corners; a "face" in answers is a
/// triangle, its parameters the weights of its second and third point.
class MeshReference final : public ModelSurface {
  public:
    /// @pre  the mesh is what make_sound leaves
    /// @throw InvalidArgument when an option is out of range or the mesh has no triangles
    explicit MeshReference(TriangleMesh mesh, const MeshReferenceOptions& options = {});
    ~MeshReference() override;
    MeshReference(MeshReference&&) noexcept;
    MeshReference& operator=(MeshReference&&) noexcept;

    [[nodiscard]] Box3 bounds() const override;
    [[nodiscard]] FootPoint foot_point(
        const Vec3& query, const std::optional<Vec3>& side = std::nullopt) const override;
    [[nodiscard]] FootPoint foot_point_on(
        const std::vector<char>& faces, const Vec3& query,
        const std::optional<Vec3>& side = std::nullopt) const override;
    [[nodiscard]] std::vector<FaceBorder> face_borders() const override;
    [[nodiscard]] const Features& features() const override;
    [[nodiscard]] FeaturePoint nearest_on_curve(
        int curve, const Vec3& query,
        const std::optional<ArcRange>& within = std::nullopt) const override;
    [[nodiscard]] FeaturePoint point_on_curve(int curve, double arc_length) const override;
    [[nodiscard]] std::optional<Curvature> curvature(const FootPoint& foot) const override;
    [[nodiscard]] std::optional<FeaturePoint> feature_point(const Vec3& query,
                                                            FeatureKind kind) const override;
    [[nodiscard]] std::vector<SurfaceSample> sample(int count) const override;
    [[nodiscard]] std::vector<SurfacePiece> pieces() const override;
    [[nodiscard]] FootPoint point_on_face(int face, const Eigen::Vector2d& uv) const override;

    /// The triangles as they are, whatever the deflection. Their faces are regions, which end at
    /// features and where parts of the file do and have the names of those parts.
    [[nodiscard]] SurfaceMesh surface_mesh(double deflection_mm) const override;
    [[nodiscard]] std::vector<std::string> face_names() const override;
    [[nodiscard]] bool has_cad_faces() const override { return false; }

    [[nodiscard]] const TriangleMesh& mesh() const;
    [[nodiscard]] int region_count() const;
    /// About how far the triangles are from the rounded surface they stand for: what 95 % of its
    /// area keeps below; millimetres.
    [[nodiscard]] double chord_error() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace patchwright::geom
#pragma GCC visibility pop
