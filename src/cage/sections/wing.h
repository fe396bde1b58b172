// Wing-like bodies: thin closed sections one after another along a span.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/wing_section.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::cage {

/// Fewer points from the trailing edge to the nose do not show the form of a section.
inline constexpr int fewest_columns = 5;

struct WingOptions {
    /// Points from the trailing edge to the nose, each side, both ends included: at least
    /// fewest_columns. Eight hold sections of usual wings within 1e-3 of the chord after a fit.
    int columns = 8;
    int spans = 5;              ///< intervals along the whole span, about
    double fineness = 1.0;      ///< bent spans are halved until they are straighter by this factor
    double tolerance_mm = 0.0;  ///< bends around are creases where smooth faces would miss it
};

enum class EndKind {
    Lid,      ///< a flat face across the span
    Open,     ///< a free edge around
    Rounded,  ///< the skin closes itself
    Ridge     ///< the skin closes in a sharp line from the trailing edge to the nose
};

struct WingEnd {
    EndKind kind = EndKind::Rounded;
    double extreme = 0.0;  ///< height where the body ends, along the span's direction
    double ring = 0.0;     ///< height of the last ring that is a section
    double outward = 1.0;  ///< sign of the span's direction
    SectionLoop rim;       ///< of an open end
    /// Of a ridge: the curve, and whether it starts at the trailing edge.
    int ridge = -1;
    bool starts_at_tail = true;
};

/// What there is to know of a wing before points are put on it.
struct Wing {
    Slicer slicer;
    double span = 0.0;
    std::array<WingEnd, 2> ends;  ///< the lower one first
    bool blunt = false;
    bool nose_line =
        false;           ///< a column runs along the nose, which is sharp there on most of the span
    bool blade = false;  ///< thick sections at an end
    WingLines lines;
    std::vector<WingSection> sections;  ///< in order of height, those at the ends included
    std::vector<double> heights;        ///< of the sections
    std::vector<char> nose_on_line;     ///< one an interval of sections
};

struct WingSearch {
    std::optional<Wing> wing;
    Blocks blocks;  ///< of the wing
    std::string why_not;
};

/// Looks along directions across flat lids first, then along the axes. A wing whose faces leave
/// out a part of the body is none; see part_left_out().
WingSearch find_wing(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const WingOptions& options, Poll& poll);

/// A box of quads around the wing: rings of points at its sections, each from the trailing edge
/// around the nose, and lids of quads between the lower and the upper side where it is closed.
Blocks wing_blocks(const Wing& wing, const geom::ModelSurface& reference,
                   const WingOptions& options, Poll& poll);

/// "wing: 17 points around, 9 rings, blunt trailing edge, ends planar and rounded"
std::string describe(const Wing& wing, const WingOptions& options);

}  // namespace patchwright::cage
