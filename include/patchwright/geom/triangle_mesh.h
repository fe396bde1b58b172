// Triangles that share their vertices, as they come out of files without a CAD kernel's faces.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

struct TriangleMesh {
    Points points;  ///< millimetres
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> part;                ///< one a triangle: its number among part_names, or -1
    std::vector<std::string> part_names;  ///< as the file names them
};

/// What making a mesh sound changed.
struct MeshRepair {
    int welded = 0;      ///< points that were others'
    int degenerate = 0;  ///< triangles with two equal points that were left out
    int duplicates = 0;  ///< triangles that were left out as another one has the same points
    int turned = 0;      ///< triangles whose orientation was reversed
    int free_sides = 0;  ///< sides with one triangle only
    int bodies = 0;      ///< components connected by sides
    int closed_bodies = 0;
    int hollows = 0;  ///< of the closed ones: inside of others, facing inward
};

/// One mesh of loose triangles: points nearer than what single precision can tell apart become
/// one, flat triangles of two points go, neighbours are made to face the same side, and closed
/// bodies outward, but those inside others, which are hollows: inward.
/// @param source  put before every message
/// @throw InputError naming the place when a point is not finite, no triangle is left, more than
///        two triangles meet at a side, or a body has one side only (a Moebius strip)
MeshRepair make_sound(TriangleMesh& mesh, const std::string& source);

}  // namespace patchwright::geom
#pragma GCC visibility pop
