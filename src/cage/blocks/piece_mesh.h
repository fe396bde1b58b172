// A triangle mesh cut into pieces along walls: kept features of a model and paths between them.
#pragma once

#include "cage/field/field_lines.h"
#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/geom/model_surface.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace patchwright::cage {

/// Where the border of a piece passes a vertex on its way to `next`, with the piece on its left.
struct BorderPoint {
    int vertex = -1, next = -1;
    double angle = 0.0;  ///< of the piece there, radians
    int faces = 2;       ///< quads that the piece is to have there: 1 at its corners
    bool node = false;   ///< lines of the layout end here, of this piece or of a neighbour
};

using Border = std::vector<BorderPoint>;

/// Number of a border's first corner; -1: it has none.
int first_corner(const Border& border);

/// Triangles between walls, as a graph with separate points on both sides of a wall.
struct CutPiece {
    std::vector<int> triangles;
    std::vector<Border> borders;
    /// Of each border point of all borders: its border, and its number there.
    std::vector<std::pair<int, int>> border_places;
    int euler = 0;  ///< vertices - edges + faces: 1 for a disc, 0 for a ring, 2 for a sphere
    double area = 0.0;
    bool has_apex = false;  ///< a point inside without a tangent plane
    bool is_final = false;  ///< PieceMesh::piece() would make it so again

    std::vector<int> vertices;  ///< of the mesh, one a point; border points first, loop by loop
    std::vector<std::vector<std::pair<int, double>>> neighbours;  ///< not along walls; lengths

    std::vector<std::array<int, 3>> corners;  ///< points of each triangle

    [[nodiscard]] int border_count() const { return int(border_places.size()); }
    /// Border point number i of all borders.
    [[nodiscard]] const BorderPoint& border_point(int i) const {
        const auto& [border, number] = border_places[std::size_t(i)];
        return borders[std::size_t(border)][std::size_t(number)];
    }
    [[nodiscard]] int border_of(int i) const { return border_places[std::size_t(i)].first; }
};

/// A path through a piece from one point of its border to another, as numbers of its points.
using PiecePath = std::vector<int>;

/// How a path parts the angle and the faces of a border point: the side towards `next` first.
struct Parting {
    double angle = 0.0;
    int faces = 1;
    int faces_after = 1;
};

/// Edges of a mesh, by their vertices in any order.
class EdgeSet {
  public:
    void insert(int a, int b) { keys_.insert(key(a, b)); }
    void erase(int a, int b) { keys_.erase(key(a, b)); }
    [[nodiscard]] bool contains(int a, int b) const { return keys_.contains(key(a, b)); }
    /// In ascending order.
    [[nodiscard]] std::vector<std::pair<int, int>> sorted() const;

  private:
    static std::uint64_t key(int a, int b) {
        const auto [low, high] = std::minmax(a, b);
        return std::uint64_t(std::uint32_t(low)) << 32 | std::uint32_t(high);
    }

    std::unordered_set<std::uint64_t> keys_;
};

class PieceMesh {
  public:
    /// Walls are the features that the mesh has and its boundary.
    PieceMesh(geom::EditableMesh& mesh, const geom::ModelSurface& reference);

    /// One triangle of every piece.
    [[nodiscard]] std::vector<int> seeds() const;
    /// The piece that a triangle is in. Splits edges that lead from wall to wall, so that paths
    /// have room.
    CutPiece piece(int triangle);
    /// Makes a path a wall; its ends become nodes.
    void cut(const CutPiece& piece, const PiecePath& path, const Parting& start,
             const Parting& end);
    void make_node(int v) { node_[std::size_t(v)] = 1; }
    /// Makes lines walls, and takes the quads of pieces from their sectors. Vertices with more than
    /// two walls and ends of lines become nodes.
    /// @pre the lines are drawn in the mesh, and it has not been cut yet
    void add_lines(const FieldLines& made);

    /// Puts a vertex into a wall, half way along it; returns it. Pieces must be made anew then.
    int split_wall(int a, int b);

    [[nodiscard]] bool is_wall(int a, int b) const { return walls_.contains(a, b); }
    [[nodiscard]] bool is_node(int v) const { return node_[std::size_t(v)] != 0; }
    [[nodiscard]] const geom::EditableMesh& mesh() const { return mesh_; }

    /// Straightens all cuts on the surface and evens out what lies between; features stay.
    void smooth_cuts(Poll& poll);

  private:
    void add_wall(int a, int b);
    /// What is beyond the sides of a triangle, from both.
    void link(int triangle);
    /// Splits an edge; returns the new vertex.
    int split(int a, int b, const geom::Vec3& where);
    [[nodiscard]] std::vector<int> triangles_from(int triangle) const;
    /// Whether there are any.
    bool split_bridges(const std::vector<int>& triangles);
    void find_nodes();
    void widen_corners();
    /// Of the piece on the left of the way from v along a wall.
    [[nodiscard]] double angle_from(int v, int next) const;
    /// @param local   numbers of the piece's triangles, by triangle
    /// @param walked  by local triangle and side: that are on borders already
    void walk_border(CutPiece& piece, const std::vector<int>& local, int t, int k,
                     std::vector<std::array<char, 3>>& walked) const;

    geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    EdgeSet walls_;
    std::vector<std::array<int, 3>> beyond_;  ///< of each triangle, by side; -1: a wall
    std::vector<char> node_, natural_;
    struct WallSector {
        double angle;
        int faces;
    };
    std::map<std::pair<int, int>, WallSector> sectors_;  // by vertex and next one on the border
    std::vector<std::vector<int>> cuts_;                 ///< paths that were cut, as vertices
};

}  // namespace patchwright::cage
