// Which way a cage faces.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

namespace patchwright::fit {

/// Whether the limit surface's normals point against those of the reference on more than three
/// quarters of its area.
bool faces_away(const mesh::Cage& cage, const geom::ReferenceSurface& reference);

/// A reference seen from its other side.
class TurnedReference final : public geom::ReferenceSurface {
  public:
    /// Refers to `other`.
    explicit TurnedReference(const geom::ReferenceSurface& other) : other_(other) {}
    [[nodiscard]] geom::Box3 bounds() const override { return other_.bounds(); }
    [[nodiscard]] geom::FootPoint foot_point(const geom::Vec3& query,
                                             const std::optional<geom::Vec3>& side) const override {
        geom::FootPoint foot =
            other_.foot_point(query, side ? std::optional<geom::Vec3>(-*side) : std::nullopt);
        foot.normal = -foot.normal;
        return foot;
    }
    [[nodiscard]] geom::FootPoint foot_point_on(
        const std::vector<char>& faces, const geom::Vec3& query,
        const std::optional<geom::Vec3>& side) const override {
        geom::FootPoint foot = other_.foot_point_on(
            faces, query, side ? std::optional<geom::Vec3>(-*side) : std::nullopt);
        foot.normal = -foot.normal;
        return foot;
    }
    [[nodiscard]] std::vector<geom::FaceBorder> face_borders() const override {
        std::vector<geom::FaceBorder> borders = other_.face_borders();
        for (geom::FaceBorder& b : borders) std::swap(b.left, b.right);
        return borders;
    }
    [[nodiscard]] std::vector<geom::SurfaceSample> sample(int count) const override {
        std::vector<geom::SurfaceSample> samples = other_.sample(count);
        for (geom::SurfaceSample& s : samples) s.normal = -s.normal;
        return samples;
    }
    [[nodiscard]] const geom::Features& features() const override { return other_.features(); }
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within) const override {
        return other_.nearest_on_curve(curve, query, within);
    }
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override {
        return other_.point_on_curve(curve, arc_length);
    }

  private:
    const geom::ReferenceSurface& other_;
};

}  // namespace patchwright::fit
