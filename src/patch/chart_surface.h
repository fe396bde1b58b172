// One B-spline surface over a chart.
#pragma once

#include "patch/cap.h"
#include "patch/layout.h"
#include "patch/piece.h"

#include <patchwright/geom/bspline.h>

#include <unordered_map>

namespace patchwright::patch {

/// Everything about a cage that surfaces are made of.
struct SurfaceSource {
    const mesh::Cage& cage;
    subd::RingTable& table;
    std::vector<const subd::RingKind*> kinds;  ///< one a face
    std::vector<Cap> caps;
    /// Per irregular corner of a face: cap and place in its fan.
    std::unordered_map<std::int32_t, std::pair<std::int32_t, std::int32_t>> cap_at;
};

/// The limit surface over the chart with its caps; one unit of u and v a face, from 0.
geom::BsplineSurface chart_surface(const Chart& chart, const SurfaceSource& source);

}  // namespace patchwright::patch
