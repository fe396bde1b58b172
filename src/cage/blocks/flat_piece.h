// A piece of a model's surface laid out in a convex polygon of the plane.
#pragma once

#include <patchwright/geom/types.h>

#include <array>
#include <vector>

namespace patchwright::cage {

using Vec2 = Eigen::Vector2d;

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Triangles of a disc in space and in the plane, where they do not overlap.
class FlatPiece {
  public:
    /// Inner points go where they are means of their neighbours by mean value weights, so that no
    /// triangle folds as long as the border is convex.
    /// Source: Tutte, How to draw a graph (1963); Floater, Mean value coordinates (2003).
    /// @param points   in space; border points first
    /// @param border   where the first points go
    /// @throw LayoutRefused when triangles without area leave no solution
    FlatPiece(std::vector<geom::Vec3> points, std::vector<std::array<int, 3>> triangles,
              std::vector<Vec2> border);

    [[nodiscard]] const std::vector<geom::Vec3>& points() const { return points_; }
    [[nodiscard]] const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
    /// Where the points go.
    [[nodiscard]] const std::vector<Vec2>& flat() const { return flat_; }

    struct SurfacePoint {
        geom::Vec3 point, normal;
        int triangle = 0;
    };
    /// The point in space that goes to p, with the normal of its triangle; p may lie a little
    /// outside.
    [[nodiscard]] SurfacePoint at(const Vec2& p) const;

  private:
    std::vector<geom::Vec3> points_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<Vec2> flat_;
};

}  // namespace patchwright::cage
