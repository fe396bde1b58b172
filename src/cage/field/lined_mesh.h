// A triangle mesh with a cross field into which lines are drawn.
#pragma once

#include "cage/field/cross_field.h"
#include "cage/field/vertex_fan.h"

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace patchwright::cage {

/// Where a direction at a vertex is, between features.
struct PolarPlace {
    int first = -1;      ///< the fan begins at the side that leads there
    double angle = 0.0;  ///< from that side, radians
    int triangle = -1;
};

/// The point (1 - t) a + t b of a side.
struct SidePoint {
    int a = -1, b = -1;
    double t = 0.0;
};

/// Lines are paths along sides. Vertices that are added lie on the triangles as they are.
class LinedMesh {
  public:
    /// Both are changed as lines are drawn.
    LinedMesh(geom::EditableMesh& mesh, CrossField& field);

    [[nodiscard]] const geom::EditableMesh& mesh() const { return mesh_; }
    [[nodiscard]] const geom::Vec3& direction(int t) const {
        return field_.direction[std::size_t(t)];
    }
    [[nodiscard]] const std::vector<std::vector<int>>& lines() const { return lines_; }

    [[nodiscard]] bool is_line(int a, int b) const { return sides_.contains(std::minmax(a, b)); }
    [[nodiscard]] bool is_feature(int t, int k) const { return is_border(mesh_, t, k); }
    [[nodiscard]] bool is_wall(int t, int k) const;
    /// On a feature, a boundary or a line.
    [[nodiscard]] bool on_wall(int v) const { return on_wall_[std::size_t(v)] != 0; }
    void set_on_wall(int v) { on_wall_[std::size_t(v)] = 1; }

    [[nodiscard]] geom::Vec3 point(const SidePoint& p) const;
    int split(const SidePoint& where);
    /// Draws a line along sides. @pre there is a side between each vertex and the next
    void draw(const std::vector<int>& path, int line);
    /// A new line, without vertices.
    int add_line();

    /// All around an inner vertex, and of others each fan between features.
    [[nodiscard]] std::vector<VertexFan> fans(int v) const;
    [[nodiscard]] PolarPlace place_of(int v, const geom::Vec3& direction) const;
    /// The direction at an angle from the first side of a fan of vertex v.
    [[nodiscard]] geom::Vec3 direction_at(int v, const VertexFan& fan, double angle) const;

  private:
    geom::EditableMesh& mesh_;
    CrossField& field_;
    std::map<std::pair<int, int>, int> sides_;  ///< line on each
    std::vector<std::vector<int>> lines_;
    std::vector<char> on_wall_;
};

}  // namespace patchwright::cage
