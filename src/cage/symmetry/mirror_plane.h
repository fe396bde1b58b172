// Planes that bodies are their own mirror images in.
#pragma once

#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/geom/model_surface.h>

#include <optional>

namespace patchwright::cage {

/// The points p with normal . p = offset.
struct MirrorPlane {
    geom::Vec3 normal = geom::Vec3::UnitX();  ///< unit
    double offset = 0.0;                      ///< millimetres

    [[nodiscard]] double height(const geom::Vec3& p) const { return normal.dot(p) - offset; }
    [[nodiscard]] geom::Vec3 onto(const geom::Vec3& p) const { return p - height(p) * normal; }
    [[nodiscard]] geom::Vec3 mirrored(const geom::Vec3& p) const {
        return p - 2.0 * height(p) * normal;
    }
    [[nodiscard]] geom::Vec3 mirrored_direction(const geom::Vec3& d) const {
        return d - 2.0 * normal.dot(d) * normal;
    }
};

/// Normals of such planes are principal axes of the surface's moments; that whose section is
/// shortest where there are several. None where two moments are equal, as of bodies of revolution
/// and square plates: moments do not tell all planes there.
/// @param body       of a fine mesh: mirror images of its vertices must lie on the reference, of
///                   those on sharp and free curves on such curves
/// @param within_mm  as near as this
std::optional<MirrorPlane> mirror_plane(const SurfaceBody& body,
                                        const geom::ModelSurface& reference, double within_mm,
                                        Poll& poll);

}  // namespace patchwright::cage
