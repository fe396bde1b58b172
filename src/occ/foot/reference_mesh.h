// The triangulation that seeds foot points: how far it is from the true faces is part of it.
#pragma once

#include "geom/triangle_tree.h"
#include "occ/foot/face_surface.h"

#include <patchwright/base/progress.h>

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace patchwright::occ {

struct MeshTriangle {
    std::array<geom::Vec3, 3> corner;
    std::array<Vec2, 3> uv;
    std::array<int, 3> node{};  ///< numbers of the corners; triangles of a face share them
    geom::Vec3 normal;          ///< unit, outward; zero when the triangle has no area
    double error = 0.0;         ///< largest distance between the triangle and its part of the face
    /// The face's trim may leave out parts of the triangle, but none farther than this from its
    /// edge.
    double overhang = 0.0;
    /// Tangent of the largest angle between the triangle's normal and those of its part of the
    /// face; infinity where that part has a point without a normal, and beside edges that lie off
    /// the face, as its end may be nearer than they are.
    double spread = 0.0;
    double turn_rad = 0.0;  ///< largest such angle, as sampled
    /// Largest curvature of the face's part towards the outward normal and away from it, as
    /// sampled; 1/mm, at least 0.
    double bend_out = 0.0, bend_in = 0.0;
    double area = 0.0;
    double sickle = 0.0;  ///< part of `error` that lies beside the triangle, at the face's border
    double stride = 0.0;  ///< how far a descent may step at once
    int face = -1;
};

/// What a search asks of every triangle it passes, a leaf of the tree at once: the same, rounded up
/// to single precision. Lanes that hold none are never near.
struct alignas(64) SeedBlock {
    using Lanes = std::array<float, geom::TriangleTree::lanes>;
    Lanes error{-1e30f, -1e30f, -1e30f, -1e30f};
    Lanes overhang{infinite, infinite, infinite, infinite};
    Lanes spread{};
    std::array<std::int32_t, geom::TriangleTree::lanes> triangle{-1, -1, -1, -1};

  private:
    static constexpr float infinite = std::numeric_limits<float>::infinity();
};

/// What a descent from a triangle needs: one line of the cache.
struct alignas(64) SeedStart {
    std::array<Vec2, 3> uv;
    /// Largest curvature towards where the triangle's corners turn left, and away from there.
    std::array<float, 2> bend;
    float stride;
    std::int32_t face;
};

/// What is around a triangle: lets a search do without looking there.
struct alignas(32) Surroundings {
    std::array<std::int32_t, 3> node{-1, -1, -1};
    /// A foot in the triangle's part of the face, and no farther from the query than a good part of
    /// the radius of this curvature, is the nearest point of all triangles of the face that share a
    /// node: towards the outward normal and away from it, 1/mm.
    std::array<float, 2> bend{infinite, infinite};
    /// Edges of the face that these triangles reach run on the face itself.
    bool tight = false;
    /// No edge of the model is nearer to the flat triangle, and none runs through its part of the
    /// face, which is inside the trim. Negative where that is not known.
    float clearance = -1.0f;

  private:
    static constexpr float infinite = std::numeric_limits<float>::infinity();
};

/// The rectangle around a triangle in (u, v).
FaceSurface::Rectangle box_of(const std::array<Vec2, 3>& uv);

struct ReferenceMesh {
    std::vector<MeshTriangle> triangles;  ///< face by face
    std::vector<std::size_t> first;       ///< of each face's triangles, and one past the last
    geom::TriangleTree tree;              ///< boxes grown by the triangles' errors
    std::vector<SeedBlock> seeds;         ///< by the tree's leaves
    std::vector<SeedStart> starts;        ///< by the tree's slots
    std::vector<Surroundings> around;     ///< the same
    int nodes = 0;                        ///< corners in all
    bool covers_edges = true;             ///< no edge is farther from its triangles than they err
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
/// @throw Cancelled when the callback stops it
ReferenceMesh triangulate(const SearchableShape& model, const std::vector<FaceSurface>& surfaces,
                          double deflection, const base::Progress& progress = {});

}  // namespace patchwright::occ
