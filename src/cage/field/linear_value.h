// Numbers that depend on one unknown at most.
#pragma once

#include "cage/blocks/flat_piece.h"

#include <array>

namespace patchwright::cage {

/// constant + factor times an unknown; -1: no unknown.
struct LinearValue {
    double constant = 0.0, factor = 0.0;
    int unknown = -1;
};
/// Of a point in the plane.
using LinearPoint = std::array<LinearValue, 2>;

inline LinearValue operator+(LinearValue v, double c) {
    v.constant += c;
    return v;
}
inline LinearValue operator-(LinearValue v) { return {-v.constant, -v.factor, v.unknown}; }

/// Turned by quarters, counter-clockwise.
inline LinearPoint turned(const LinearPoint& v, int quarters) {
    switch ((quarters % 4 + 4) % 4) {
        case 0: return v;
        case 1: return {-v[1], v[0]};
        case 2: return {-v[0], -v[1]};
        default: return {v[1], -v[0]};
    }
}
inline LinearPoint operator+(LinearPoint v, const Vec2& c) { return {v[0] + c.x(), v[1] + c.y()}; }

}  // namespace patchwright::cage
