// Sectors of triangles between features.
#pragma once

#include "geom/editable_mesh.h"

#include <array>
#include <vector>

namespace patchwright::cage {

/// The triangles at a vertex between two features, or all of them.
struct FaceSector {
    int faces = 0;  ///< as pairing goes on
    int least = 1;  ///< with fewer the surface has no proper tangent plane there
    double angle_rad = 0.0;
};

/// The sectors of all vertices, and which one each corner of a triangle is in.
struct Sectors {
    std::vector<FaceSector> sectors;
    std::vector<std::array<int, 3>> of_corner;
};

Sectors sectors_of(const geom::EditableMesh& mesh);

}  // namespace patchwright::cage
