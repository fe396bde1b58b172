// The nearest points of a triangle and of a segment.
#pragma once

#include <patchwright/geom/types.h>

#include <algorithm>
#include <array>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Barycentric weights of a triangle's point nearest to `p`; the first corner where the triangle
/// is too thin to tell (Ericson, Real-time collision detection, 2004, 5.1.5).
Vec3 nearest_weights(const Vec3& p, const std::array<Vec3, 3>& corner);

/// A point of a segment.
struct SegmentPoint {
    double share = 0.0;  ///< of the way from the first end to the second
    Vec3 point = Vec3::Zero();
};

/// The segment's point nearest to `p`; the first end where both ends are the same.
inline SegmentPoint nearest_on_segment(const Vec3& p, const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    const double square = along.squaredNorm();
    const double share = square > 0.0 ? std::clamp((p - from).dot(along) / square, 0.0, 1.0) : 0.0;
    return {share, from + share * along};
}

}  // namespace patchwright::geom
#pragma GCC visibility pop
