// Normals and curvature of the surface that a mesh's triangles stand for.
#pragma once

#include "geom/mesh_features.h"

#include <patchwright/geom/model_surface.h>

#include <array>
#include <vector>

namespace patchwright::geom {

/// One entry a corner of a triangle, in the triangles' order; corners around a point between two
/// features have the same.
struct MeshBend {
    std::vector<std::array<int, 3>> sector;  ///< one a triangle: numbers in what follows
    std::vector<Vec3> normal;                ///< unit, or zero; outward
    std::vector<Eigen::Matrix3d> shape;      ///< 1/mm: how the normal turns, in space
};

/// Normals weighted by angle, curvature by how they turn over the triangles.
/// Source: Rusinkiewicz, Estimating curvatures and their derivatives on triangle meshes (2004).
MeshBend measure_mesh_bend(const TriangleMesh& mesh, const MeshFeatures& features);

}  // namespace patchwright::geom
