// Whether a point is beside an edge of a shape or of its approximation.
#pragma once

#include "geom/bvh.h"

#include <patchwright/geom/bspline.h>
#include <patchwright/geom/reference_surface.h>

#include <array>
#include <vector>

namespace patchwright::measure {

/// Sharp and free curves and corners of a shape, and given curves.
class NearCurves {
  public:
    /// @pre reach_mm > 0; `shape` outlives this
    NearCurves(const geom::ReferenceSurface& shape, const std::vector<geom::BsplineCurve>& curves,
               double reach_mm);
    /// Whether one of them is within reach. Thread-safe.
    [[nodiscard]] bool is_near(const geom::Vec3& p) const;

  private:
    struct Arc {
        int curve;
        geom::ArcRange range;
    };
    void add_features();
    void add_curve(const geom::BsplineCurve& curve);

    const geom::ReferenceSurface& shape_;
    double reach_;
    std::vector<Arc> arcs_;
    std::vector<std::array<geom::Vec3, 2>> segments_;  ///< corners with both ends equal
    geom::Bvh tree_;                                   ///< over the arcs, then the segments
};

}  // namespace patchwright::measure
