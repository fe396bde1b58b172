// Whether a point lies beside an edge across which a model has no tangent plane.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::measure {

/// Smooth curves whose faces meet at more than this somewhere, by number.
std::vector<int> kinked_curves(const geom::ModelSurface& model, double least_angle_rad);

/// Sharp and free edges, and smooth ones whose faces meet at more than a given angle somewhere.
class CreaseDistance {
  public:
    CreaseDistance(const geom::ModelSurface& model, double least_angle_rad);

    [[nodiscard]] bool is_within(const geom::Vec3& point, double reach_mm) const;

  private:
    const geom::ModelSurface& model_;
    std::vector<int> kinked_;  ///< smooth curves that count
};

}  // namespace patchwright::measure
