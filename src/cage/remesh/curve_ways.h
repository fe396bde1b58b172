// Ways along feature curves between the vertices of a cage.
#pragma once

#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

namespace patchwright::cage {

class CurveWays {
  public:
    CurveWays(const geom::ModelSurface& reference, Poll& poll)
        : reference_(reference), poll_(poll) {}

    /// The arc length, millimetres, of the point of a curve that is nearest to p.
    [[nodiscard]] double arc_at(int curve, const geom::Vec3& p) const;
    /// Along a curve; on closed ones the shorter way, either of which may be negative.
    [[nodiscard]] double way(int curve, double from, double to) const;
    /// The point half of the way from a to b. Not the point nearest to the middle of the chord: on
    /// a slim loop that may be on its other side.
    [[nodiscard]] geom::Vec3 middle(int curve, const geom::Vec3& a, const geom::Vec3& b) const;

  private:
    const geom::ModelSurface& reference_;
    Poll& poll_;
};

}  // namespace patchwright::cage
