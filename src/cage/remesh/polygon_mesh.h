// Quads and triangles of a cage as they are edited: who is beside whom, and what a vertex needs.
#pragma once

#include "geom/editable_mesh.h"

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace patchwright::cage {

/// Faces of a cage with the vertices of a mesh.
struct Polygons {
    std::vector<std::vector<int>> corners;  ///< counter-clockwise; three or four each
    std::vector<int> faces;                 ///< of the model
};

/// Polygons with the vertices and features of a mesh.
class PolygonMesh {
  public:
    PolygonMesh(Polygons polygons, geom::EditableMesh& mesh);

    /// Those that are not empty.
    [[nodiscard]] Polygons polygons() const;
    [[nodiscard]] const geom::EditableMesh& mesh() const { return mesh_; }

    // As those of the mesh.
    [[nodiscard]] geom::VertexKind kind(int v) const { return kinds_[std::size_t(v)]; }
    [[nodiscard]] bool is_boundary(int v) const { return boundary_[std::size_t(v)]; }
    [[nodiscard]] bool is_feature(int a, int b) const;

    [[nodiscard]] int count() const { return int(polygons_.corners.size()); }
    /// Empty for a polygon that was removed.
    [[nodiscard]] const std::vector<int>& corners(int polygon) const {
        return polygons_.corners[std::size_t(polygon)];
    }
    [[nodiscard]] const std::vector<int>& at_vertex(int v) const {
        return at_vertex_[std::size_t(v)];
    }
    /// Two polygons, one at boundaries, none where there is no such edge.
    [[nodiscard]] const std::vector<int>& of_edge(int a, int b) const;
    /// The vertices after and before v.
    [[nodiscard]] std::array<int, 2> neighbours_in(int polygon, int v) const;
    [[nodiscard]] double quality(int polygon) const;
    /// The shortest edge over the longest one.
    [[nodiscard]] double edge_ratio(int polygon) const;
    /// The least cosine of the angles between its normal and those of its neighbours in the region.
    [[nodiscard]] double cosine_to_neighbours(int polygon) const;
    /// The polygons at a vertex between two features, or all of them.
    [[nodiscard]] std::vector<std::vector<int>> sectors(int v) const;

    /// Removes a polygon when there are no corners.
    void replace(int polygon, std::vector<int> corners);
    /// A polygon of the same face of the model as another one.
    int add(std::vector<int> corners, int like);
    void move(int v, const geom::Vec3& p) { mesh_.move(v, p); }
    /// A vertex of no polygon, on no feature.
    int add_vertex(const geom::Vec3& p);
    /// Puts a vertex into a feature edge, and into the polygons beside it.
    int split_feature(int a, int b, const geom::Vec3& p);

    /// The region between features that each polygon is in, from 0; -1 for removed ones.
    [[nodiscard]] std::vector<int> regions() const;

    /// Whether a polygon has at most two vertices in common with any neighbour, and one neighbour
    /// across each edge.
    [[nodiscard]] bool shares_edges_only(int polygon) const;
    /// How many faces a vertex lacks in the sectors between features, and how many of them are
    /// unevenly divided: 0 when the limit surface is sound there.
    [[nodiscard]] int flaws(int v) const;
    /// Sum over the sectors of a vertex of the squared difference between the number of its faces
    /// and the one that is regular there.
    [[nodiscard]] int irregularity(int v) const;

  private:
    [[nodiscard]] double angle_at(int polygon, int v) const;
    [[nodiscard]] geom::Vec3 normal(int polygon) const;
    [[nodiscard]] int flaws(int v, const std::vector<int>& sector) const;
    [[nodiscard]] int regular_faces(int v, const std::vector<int>& sector) const;
    void attach(int polygon);
    void detach(int polygon);

    Polygons polygons_;
    geom::EditableMesh& mesh_;
    std::vector<geom::VertexKind> kinds_;
    std::vector<bool> boundary_;
    std::vector<std::vector<int>> at_vertex_;
    std::map<std::pair<int, int>, std::vector<int>> of_edge_;
};

}  // namespace patchwright::cage
