// A wing with foot points by Newton's method on its own formula.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

namespace patchwright::test {

enum class WingSection {
    Naca,   ///< NACA 0012, at whose nose curvature has a kink, with curvature at the trailing edge
    Smooth  ///< as thick at the nose, without either: half thickness sqrt(x) (1 - x) (1 - x / 3)
};

/// A swept and tapered wing of straight lines from root to tip with a sharp trailing edge, open
/// at both ends: root chord 2, tip chord 1, span 4. Features: curve 0 the trailing edge
/// (sharp), 1 and 2 the rims of root and tip (free, from corner to the same corner).
class NacaWing final : public geom::ReferenceSurface {
  public:
    explicit NacaWing(WingSection section = WingSection::Naca);
    [[nodiscard]] geom::Box3 bounds() const override;
    [[nodiscard]] geom::FootPoint foot_point(
        const geom::Vec3& query, const std::optional<geom::Vec3>& side = {}) const override;
    [[nodiscard]] const geom::Features& features() const override { return features_; }
    [[nodiscard]] geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& query,
        const std::optional<geom::ArcRange>& within = {}) const override;
    [[nodiscard]] geom::FeaturePoint point_on_curve(int curve, double arc_length) const override;

    /// s from -1 (trailing edge, below) over 0 (nose) to 1; t from 0 (root) to 1 (tip).
    [[nodiscard]] static geom::Vec3 point(double s, double t,
                                          WingSection section = WingSection::Naca);

  private:
    WingSection section_;
    geom::Features features_;
    std::vector<double> arc_;  // of a section with chord 1, at equal steps of s
    [[nodiscard]] double parameter_at(double share) const;
    [[nodiscard]] double share_at(double s) const;
};

/// A cage beside it: `around` quads from the trailing edge round the nose to it, denser towards
/// the nose, `along` from root to tip; its trailing edge is sharp. @pre around is even
mesh::Cage naca_wing_cage(int around, int along, WingSection section = WingSection::Naca);

}  // namespace patchwright::test
