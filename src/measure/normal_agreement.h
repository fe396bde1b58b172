// Whether a surface faces as the shape does that it approximates.
#pragma once

#include <patchwright/geom/reference_surface.h>

namespace patchwright::measure {

/// Looks for points of the input that face the way a sample of the output does.
class NormalAgreement {
  public:
    /// @param angle_rad  normals that differ by more disagree
    /// @param sign       of the output's normals: -1 where it faces the other way as a whole
    /// @pre `input` outlives this
    NormalAgreement(const geom::ReferenceSurface& input, double tolerance_mm, double angle_rad,
                    double sign = 1.0)
        : input_(input), tolerance_(tolerance_mm), limit_(angle_rad), sign_(sign) {}

    /// Radians between the normals of the sample and at its foot; half a turn where that has none.
    [[nodiscard]] double angle_at_foot(const geom::Vec3& point, const geom::Vec3& normal) const;

    /// Least angle to the input's normals within the sample's distance plus two tolerances; ends
    /// early at one that agrees.
    [[nodiscard]] double least_angle(const geom::Vec3& point, const geom::Vec3& normal) const;

  private:
    const geom::ReferenceSurface& input_;
    double tolerance_, limit_, sign_;
};

}  // namespace patchwright::measure
