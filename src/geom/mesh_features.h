// Feature curves and corners of a triangle mesh.
#pragma once

#include <patchwright/geom/mesh_reference.h>

#include <vector>

namespace patchwright::geom {

/// A feature curve as a line through points of the mesh; a closed one ends at its first point.
struct MeshChain {
    std::vector<int> points;
    std::vector<double> arc;  ///< at each point, from 0
};

struct MeshFeatures {
    Features features;
    std::vector<MeshChain> chains;  ///< one a curve
    std::vector<FeatureSide> sides;
    std::vector<int> corner_of;  ///< one a point of the mesh: number of its corner, or -1
    std::vector<std::array<int, 3>> curve_under;  ///< one a triangle: under each side, or -1
    std::vector<std::array<int, 3>> beyond;       ///< one a triangle: triangle there, or -1
};

/// Sides are sharp where triangles meet at more than the angle, free where there is one triangle.
/// Corners are where other than two of them meet, where they turn by more than the angle, and
/// points like the tip of a cone. Short sharp lines that end inside a smooth surface are accidents
/// of the triangles and no features.
MeshFeatures find_mesh_features(const TriangleMesh& mesh, double sharp_angle_rad);

}  // namespace patchwright::geom
