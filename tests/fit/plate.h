// A reference whose feature curves are a free rim with corners.
#pragma once

#include "support/analytic_references.h"

namespace patchwright::test {

/// A square plate whose upper rim is free and has corners.
class Plate final : public geom::ReferenceSurface {
  public:
    Plate() : features_(box_.features()) {
        for (geom::FeatureCurve& c : features_.curves) {
            const bool upper = c.start_corner >= 4 && c.end_corner >= 4;
            c.kind = upper ? geom::FeatureKind::Free : geom::FeatureKind::Smooth;
        }
    }
    geom::Box3 bounds() const override { return box_.bounds(); }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        geom::Vec3 p = q.cwiseMax(-1).cwiseMin(1);
        p.z() = thickness;
        return {p, geom::Vec3::UnitZ(), (q - p).norm(), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& q,
        const std::optional<geom::ArcRange>& within) const override {
        return box_.nearest_on_curve(curve, q, within);
    }
    geom::FeaturePoint point_on_curve(int curve, double s) const override {
        return box_.point_on_curve(curve, s);
    }
    static constexpr double thickness = 1e-3;

  private:
    Box box_{geom::Vec3(1, 1, thickness)};
    geom::Features features_;
};

}  // namespace patchwright::test
