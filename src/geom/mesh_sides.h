// What lies beyond the sides of a mesh's triangles.
#pragma once

#include <patchwright/geom/triangle_mesh.h>

#include <array>
#include <vector>

namespace patchwright::geom {

/// A side that one or more triangles have; side k of a triangle runs from corner k to the next.
struct MeshSide {
    int low, high;       ///< points
    int triangle, side;  ///< one that has it
};

/// All sides of all triangles, those between the same points next to each other, in order of
/// points, then triangles.
std::vector<MeshSide> sorted_sides(const TriangleMesh& mesh);

[[nodiscard]] inline Vec3 corner_point(const TriangleMesh& mesh, int triangle, int corner) {
    return mesh.points.row(mesh.triangles[std::size_t(triangle)][std::size_t(corner % 3)]);
}

/// Twice the area, along the normal.
[[nodiscard]] Vec3 area_vector(const TriangleMesh& mesh, int triangle);

}  // namespace patchwright::geom
