// A model as one connected triangle mesh whose edges know the features they lie on.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// A side of a triangle that lies on a feature curve.
struct FeatureSide {
    int v0, v1;  ///< v0 < v1
    int curve;   ///< number among Features::curves of the model
};

/// Triangles of neighbouring faces share their vertices. No edge has more than two triangles, and
/// the triangles at a vertex form one fan.
struct SurfaceMesh {
    Points points;                              ///< on the model
    std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
    std::vector<int> faces;             ///< one a triangle: number among ModelSurface::face_names()
    std::vector<FeatureSide> features;  ///< each side once
    std::vector<int> corners;           ///< one a point: its number among Features::corners, or -1
    int faces_without = 0;              ///< faces that could not be triangulated: holes
};

}  // namespace patchwright::geom
#pragma GCC visibility pop
