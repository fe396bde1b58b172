// A CAD model as one connected triangle mesh whose edges know the features they lie on.
#pragma once

#include <patchwright/occ/cad_reference.h>

#include <array>
#include <vector>

namespace patchwright::occ {

/// A side of a triangle that lies on a feature curve of any kind.
struct FeatureSide {
    int v0, v1;  ///< v0 < v1
    int curve;   ///< number among Features::curves of the reference
};

/// Triangles of neighbouring faces share their vertices. No edge has more than two triangles, and
/// the triangles at a vertex form one fan.
struct SurfaceMesh {
    geom::Points points;                        ///< on the model
    std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
    std::vector<int> faces;                     ///< of the model, one a triangle
    std::vector<FeatureSide> features;          ///< each side once
    std::vector<int> corners;  ///< one a point: its number among Features::corners, or -1
    int faces_without = 0;     ///< faces that the kernel could not triangulate: holes
};

/// @param reference  of this model
/// @param deflection_mm  largest distance of a triangle from its face, as far as the kernel keeps
/// it
/// @throw InputError when nothing can be triangulated
SurfaceMesh surface_mesh(const CadModel& model, const CadReference& reference,
                         double deflection_mm);

}  // namespace patchwright::occ
