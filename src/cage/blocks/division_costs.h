// What numbers of edges cost: the same for those that are made and for those that are improved.
#pragma once

#include "cage/blocks/block_layout.h"

#include <algorithm>
#include <cmath>

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

/// Stands for no edge, of which there is no logarithm.
constexpr double no_edge = 0.05;

/// What an arc costs that has n edges: wanted log^2(n / wanted), near n = wanted as
/// (n - wanted)^2 / wanted. Half as many edges as wanted are as bad as twice as many, so that noses
/// get theirs, and none is best where a single one would be far longer than wide.
inline double division_penalty(const LayoutArc& arc, int n) {
    const double w = wanted_edges(arc);
    const double wanted = std::max(arc.wanted, no_edge);
    const double l = std::log(std::max(double(n), no_edge) / wanted);
    return w * l * l;
}

}  // namespace patchwright::cage
