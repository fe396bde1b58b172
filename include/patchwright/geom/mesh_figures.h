// Measures of a triangle mesh.
#pragma once

#include <patchwright/geom/triangle_mesh.h>

#include <array>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Lengths in millimetres.
struct MeshFigures {
    int sides = 0, free_sides = 0;
    double area = 0.0;
    double volume = 0.0;  ///< enclosed; means little where a body is open
    /// Of the volume when asked for, else of the surface.
    Vec3 centre = Vec3::Zero();
    /// About the centre, of density 1, least first; mm^5 for volumes, mm^4 for surfaces.
    std::array<double, 3> moments{0.0, 0.0, 0.0};
    int smallest = 0, narrowest = 0;                    ///< triangles
    double smallest_area = 0.0, narrowest_width = 0.0;  ///< twice the area by the perimeter
    double shortest_side = 0.0;
    Vec3 shortest_at = Vec3::Zero();  ///< its middle
};

/// @param of_volume  whether centre and moments are those of the volume
/// @pre  the mesh has triangles
MeshFigures measure_mesh(const TriangleMesh& mesh, bool of_volume);

}  // namespace patchwright::geom
#pragma GCC visibility pop
