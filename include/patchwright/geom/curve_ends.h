// Where feature curves hang together, smooth ones too, which have no corners.
#pragma once

#include <patchwright/geom/features.h>

#include <array>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

struct CurveEnds {
    std::vector<Vec3> points;  ///< of places; the first ones are the corners, in their order
    /// Place of each curve's start and end; -1 for closed curves without a corner.
    std::vector<std::array<int, 2>> places;
    struct End {
        int curve;
        bool at_end;  ///< of the curve; else at its start
    };
    std::vector<std::vector<End>> curves;  ///< that begin or end there, by place; in their order
};

/// @param same_mm  ends that are nearer to each other than this are in one place
CurveEnds curve_ends(const Features& features, double same_mm);

}  // namespace patchwright::geom
#pragma GCC visibility pop
