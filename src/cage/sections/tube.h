// Bodies around an axis: every half plane from the axis cuts them in one line, as nacelles.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/geom/model_surface.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

struct TubeOptions {
    int around = 16;        ///< lines along the body, a multiple of 8: four sides of even numbers
    double fineness = 1.0;  ///< rings are nearer to each other by this factor
    double tolerance_mm = 0.0;  ///< bends around are creases where smooth faces would miss it
};

/// How a line in a half plane starts or ends.
enum class LineEnd {
    Free,  ///< at a free edge
    Axis,  ///< on the axis
    None   ///< nowhere: the line is closed
};

/// The line in one half plane, from sharp curve to sharp curve.
struct TubeLine {
    std::vector<std::vector<geom::Vec3>> pieces;  ///< each with both ends
    geom::Vec3 outward = geom::Vec3::Zero();      ///< unit, from the axis

    [[nodiscard]] double length(int piece) const;
    /// Point of a piece at this share of its length.
    [[nodiscard]] geom::Vec3 at(int piece, double share) const;
};

struct Tube {
    geom::Vec3 center = geom::Vec3::Zero(), axis = geom::Vec3::UnitZ();
    LineEnd start = LineEnd::None, end = LineEnd::None;
    bool sharp_start = false;  ///< closed lines: they start at a sharp curve
    /// Of a start and an end on the axis that are no caps but points without a tangent plane.
    std::array<std::optional<geom::Vec3>, 2> tips;
    std::vector<TubeLine> lines;
    /// Shares at which rings lie, one list a piece, both ends included; a share 0 on the axis is
    /// omitted, as is 1.
    std::vector<std::vector<double>> shares;
};

struct TubeSearch {
    std::optional<Tube> tube;
    std::string why_not;
};

/// Looks around the three axes through the centre of the body's surface.
TubeSearch find_tube(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const TubeOptions& options, Poll& poll);

/// Rings of quads; a square of quads with four vertices of valence 3 where lines end on the axis,
/// its middle a corner where that is a tip.
Blocks tube_blocks(const Tube& tube, const geom::ModelSurface& reference, Poll& poll);

/// "nacelle: 16 lines x 14 rings, ends open and open, 1 sharp ring"
std::string describe(const Tube& tube);

}  // namespace patchwright::cage
