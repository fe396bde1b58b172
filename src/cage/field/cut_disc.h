// The triangles of a flat piece while lines are cut into them.
#pragma once

#include "cage/blocks/flat_piece.h"

#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace patchwright::cage {

/// Triangles of a disc in space and in the plane. Vertices on its border or on lines are on walls.
class CutDisc {
  public:
    /// @param border  how many points of the piece are on its border
    CutDisc(const FlatPiece& piece, int border);

    [[nodiscard]] const geom::Vec3& point(int v) const { return points_[std::size_t(v)]; }
    [[nodiscard]] const Vec2& flat(int v) const { return flat_[std::size_t(v)]; }

    /// An inner vertex at p: one that moves there on the flat piece, or another one.
    /// @throw LayoutRefused when p is outside
    int add_vertex(const Vec2& p);
    /// Splits a side at a share t of the way from a to b. @return the vertex there
    int split(int a, int b, double t, const geom::Vec3& point);
    /// A line from one vertex to another, straight on the flat piece. Vertices near it move onto
    /// it.
    /// @return its vertices
    /// @throw LayoutRefused when a wall is in the way
    std::vector<int> draw(int from, int to);

    /// What a closed line of walls bounds on its left. Splits sides that lead from one of its
    /// vertices to another, so that no triangle is flattened when its border is laid out anew.
    /// @param loop    without the first vertex at the end
    /// @param border  where its vertices go
    [[nodiscard]] FlatPiece piece(const std::vector<int>& loop, std::vector<Vec2> border);

  private:
    [[nodiscard]] bool has_side(int a, int b) const { return left_.contains({a, b}); }
    void set_triangle(int t, const std::array<int, 3>& corners);
    void replace(int t, int from, int to);
    [[nodiscard]] bool on_wall(int v) const { return on_wall_[std::size_t(v)] != 0; }
    bool move(int v, const Vec2& p);
    int step_towards(int v, int to);
    [[nodiscard]] std::vector<int> triangles_within(const std::vector<int>& loop) const;

    std::vector<geom::Vec3> points_;
    std::vector<Vec2> flat_;
    std::vector<char> on_wall_;
    std::vector<std::array<int, 3>> triangles_;
    std::map<std::pair<int, int>, int> left_;  ///< the triangle on the left of a side
    std::set<std::pair<int, int>> walls_;      ///< sides of lines
};

}  // namespace patchwright::cage
