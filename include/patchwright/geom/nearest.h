// The nearest point of a triangle.
#pragma once

#include <patchwright/geom/types.h>

#include <array>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Barycentric weights of a triangle's point nearest to `p`; the first corner where the triangle
/// is too thin to tell (Ericson, Real-time collision detection, 2004, 5.1.5).
Vec3 nearest_weights(const Vec3& p, const std::array<Vec3, 3>& corner);

}  // namespace patchwright::geom
#pragma GCC visibility pop
