// The triangulation that seeds foot points: how far it is from the true faces is part of it.
#pragma once

#include "face_surface.h"

#include <patchwright/geom/triangle_tree.h>

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <array>
#include <cstdint>
#include <vector>

namespace patchwright::occ {

struct MeshTriangle {
    std::array<geom::Vec3, 3> corner;
    std::array<Vec2, 3> uv;
    geom::Vec3 normal;   ///< unit, outward; zero when the triangle has no area
    double error = 0.0;  ///< largest distance between the triangle and its part of the face
    /// The face's trim may leave out parts of the triangle, but none farther than this from its
    /// edge.
    double overhang = 0.0;
    /// Tangent of the largest angle between the triangle's normal and those of its part of the
    /// face; infinity where that part has a point without a normal, and beside edges that lie off
    /// the face, as its end may be nearer than they are.
    double spread = 0.0;
    /// Largest curvature of the face's part towards the outward normal and away from it, as
    /// sampled; 1/mm, at least 0.
    double bend_out = 0.0, bend_in = 0.0;
    double area = 0.0;
    double sickle = 0.0;  ///< part of `error` that lies beside the triangle, at the face's border
    double stride = 0.0;  ///< how far a descent may step at once
    int face = -1;
};

/// What a search asks of every triangle it passes: the same, rounded up to single precision.
struct Seed {
    float error = 0.0f, overhang = 0.0f, spread = 0.0f;
    std::int32_t triangle = -1;
};

/// What a descent from a triangle needs: one line of the cache.
struct alignas(64) SeedStart {
    std::array<Vec2, 3> uv;
    /// Largest curvature towards where the triangle's corners turn left, and away from there.
    std::array<float, 2> bend;
    float stride;
    std::int32_t face;
};

/// The rectangle around a triangle in (u, v).
FaceSurface::Rectangle box_of(const std::array<Vec2, 3>& uv);

struct ReferenceMesh {
    std::vector<MeshTriangle> triangles;  ///< face by face
    std::vector<std::size_t> first;       ///< of each face's triangles, and one past the last
    geom::TriangleTree tree;              ///< boxes grown by the triangles' errors
    std::vector<Seed> seeds;              ///< by the tree's slots
    std::vector<SeedStart> starts;        ///< the same
    int faces_without = 0;                ///< faces the kernel could not triangulate; given a grid
};

/// A copy of a model that shares its geometry but not its triangulation, made fit for searching:
/// every edge with a curve in space and one on each face.
struct SearchableShape {
    TopoDS_Shape shape;
    std::vector<TopoDS_Face> faces;  ///< in the model's order
};

SearchableShape make_searchable(const TopoDS_Shape& shape);

/// Triangulates the faces in place, reads the result, and removes it from the shape again.
/// @param deflection  millimetres
ReferenceMesh triangulate(const SearchableShape& model, const std::vector<FaceSurface>& surfaces,
                          double deflection);

}  // namespace patchwright::occ
