// What numbers of edges cost: the same for those that are made and for those that are improved.
#pragma once

#include "cage/blocks/block_layout.h"

#include <algorithm>

namespace patchwright::cage {

/// A block's side that an arc is part of.
struct SideUse {
    int block = -1, side = -1;
};

/// In edges that an arc has too many: a valence-3 insertion is as bad as a dozen, a further strip
/// around the same corner costs little.
constexpr double first_insertion = 12.0, further_insertion = 0.5;

/// Edges that an arc should get: half a one at least, however short it is, which keeps relative
/// errors finite.
inline double wanted_edges(const LayoutArc& arc) { return std::max(0.5, arc.wanted); }

/// (n - wanted)^2 / wanted.
inline double division_penalty(const LayoutArc& arc, int n) {
    const double d = n - wanted_edges(arc);
    return d * d / wanted_edges(arc);
}

}  // namespace patchwright::cage
