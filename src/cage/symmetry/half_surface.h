// The half of a body that is its own mirror image.
#pragma once

#include "cage/symmetry/mirror_plane.h"
#include "geom/polyline.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

/// What lies on the side of the plane that its normal points to. Features keep their numbers, those
/// of the other side are there as well; after them come the lines of the section with the plane, as
/// free curves that end at features.
class HalfSurface final : public geom::ModelSurface {
  public:
    /// @return nothing where the half is no surface: parts of it would touch at points
    static std::unique_ptr<HalfSurface> of(const SurfaceBody& body,
                                           const geom::ModelSurface& reference,
                                           const MirrorPlane& plane, Poll& poll);

    [[nodiscard]] const MirrorPlane& plane() const { return plane_; }
    [[nodiscard]] const geom::ModelSurface& whole() const { return whole_; }
    /// All triangles of surface_mesh(), which must not outlive this.
    [[nodiscard]] SurfaceBody body() const;
    /// Whether a curve is a line of the section.
    [[nodiscard]] bool is_section(int curve) const { return curve >= first_section_; }

    [[nodiscard]] geom::Box3 bounds() const override { return bounds_; }
    /// Of queries on the other side that of their mirror images, as of curves.
    [[nodiscard]] geom::FootPoint foot_point(
        const geom::Vec3& query,
        const std::optional<geom::Vec3>& side = std::nullopt) const override;
    [[nodiscard]] const geom::Features& features() const override { return features_; }
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within = std::nullopt) const override;
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override;
    [[nodiscard]] std::optional<geom::FeaturePoint> feature_point(
        const geom::Vec3& query, geom::FeatureKind kind) const override;
    [[nodiscard]] std::optional<geom::Curvature> curvature(
        const geom::FootPoint& foot) const override;
    [[nodiscard]] std::vector<geom::SurfaceSample> sample(int count) const override;
    /// The whole's that reach to this side.
    [[nodiscard]] std::vector<geom::SurfacePiece> pieces() const override;
    [[nodiscard]] geom::FootPoint point_on_face(int face,
                                                const Eigen::Vector2d& uv) const override {
        return whole_.point_on_face(face, uv);
    }
    /// As fine as the body's mesh is.
    [[nodiscard]] geom::SurfaceMesh surface_mesh(double) const override { return mesh_; }
    [[nodiscard]] std::vector<std::string> face_names() const override {
        return whole_.face_names();
    }
    [[nodiscard]] bool has_cad_faces() const override { return whole_.has_cad_faces(); }

  private:
    struct Section {
        geom::Polyline line;  ///< on the plane
        std::vector<double> arc_lengths;
        std::vector<int> curves;  ///< one a step: the whole's sharp one that it is on, or -1
    };
    class Builder;

    HalfSurface(const geom::ModelSurface& whole, const MirrorPlane& plane)
        : whole_(whole), plane_(plane) {}
    [[nodiscard]] const Section& section(int curve) const {
        return sections_[std::size_t(curve - first_section_)];
    }
    [[nodiscard]] geom::Vec3 on_this_side(const geom::Vec3& p) const {
        return plane_.height(p) < 0.0 ? plane_.mirrored(p) : p;
    }
    [[nodiscard]] geom::FeaturePoint on_section(int curve, const geom::Vec3& near,
                                                std::size_t step) const;

    const geom::ModelSurface& whole_;
    MirrorPlane plane_;
    geom::SurfaceMesh mesh_;
    geom::Box3 bounds_;
    geom::Features features_;
    int first_section_ = 0;
    std::vector<Section> sections_;
};

}  // namespace patchwright::cage
