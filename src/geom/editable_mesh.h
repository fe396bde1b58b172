// The editable view of a SurfaceMesh: collapses, splits and flips that keep features and stay
// manifold.
#pragma once

#include <patchwright/geom/surface_mesh.h>
#include <patchwright/geom/types.h>

#include <array>
#include <vector>

namespace patchwright::geom {

enum class VertexKind {
    Smooth,
    Curve,  ///< inside a feature curve
    Fixed   ///< corner, end or junction of curves
};

/// The triangles on both sides of an edge; -1: none.
struct EdgeSides {
    std::array<int, 2> triangle{-1, -1};
    std::array<int, 2> side{-1, -1};  ///< number of the edge in each triangle
};

class EditableMesh {
  public:
    explicit EditableMesh(const SurfaceMesh& mesh);

    [[nodiscard]] int vertex_count() const { return int(points_.size()); }
    [[nodiscard]] int triangle_count() const { return int(triangles_.size()); }
    [[nodiscard]] bool alive(int t) const { return triangles_[std::size_t(t)][0] >= 0; }
    [[nodiscard]] bool vertex_alive(int v) const { return !fans_[std::size_t(v)].empty(); }
    [[nodiscard]] const std::array<int, 3>& triangle(int t) const {
        return triangles_[std::size_t(t)];
    }
    /// Feature curve under side k (from corner k to the next); -1: none.
    [[nodiscard]] int curve(int t, int k) const { return curves_[std::size_t(t)][std::size_t(k)]; }
    [[nodiscard]] int face(int t) const { return faces_[std::size_t(t)]; }
    [[nodiscard]] const Vec3& point(int v) const { return points_[std::size_t(v)]; }
    void move(int v, const Vec3& p) { points_[std::size_t(v)] = p; }
    [[nodiscard]] int corner(int v) const { return corners_[std::size_t(v)]; }
    [[nodiscard]] const std::vector<int>& fan(int v) const { return fans_[std::size_t(v)]; }
    [[nodiscard]] std::vector<int> neighbours(int v) const;

    [[nodiscard]] VertexKind kind(int v) const;
    /// The curve a vertex of kind Curve lies on.
    [[nodiscard]] int curve_at(int v) const;
    /// Neighbours along feature curves.
    [[nodiscard]] std::vector<int> feature_neighbours(int v) const;
    [[nodiscard]] EdgeSides sides(int a, int b) const;
    [[nodiscard]] bool is_feature(int a, int b) const;
    [[nodiscard]] bool is_boundary(int v) const;

    /// Number of the corner that a triangle has at one of its vertices.
    [[nodiscard]] int corner_of(int t, int v) const;
    /// Angle at corner k of a triangle, radians.
    [[nodiscard]] double corner_angle(int t, int k) const;
    /// Twice the area, along the normal.
    [[nodiscard]] Vec3 area_vector(int t) const;
    [[nodiscard]] Vec3 vertex_normal(int v) const;

    /// Whether `gone` may be merged into `kept` without harm to topology and features.
    [[nodiscard]] bool can_collapse(int gone, int kept) const;
    /// Whether every edge keeps one or two triangles when `gone` is merged into `kept`.
    [[nodiscard]] bool stays_manifold(int gone, int kept) const;
    /// Whether the triangles that stay keep their orientation and some height when `gone` is at
    /// `kept`. Triangles whose sides are all shorter than `negligible` may turn as they like.
    [[nodiscard]] bool collapse_is_flat(int gone, int kept, double least_cosine,
                                        double negligible = 0.0) const;
    /// Where two feature curves become one side, it is on that of `kept`.
    void collapse(int gone, int kept);
    /// A vertex of no triangle, on no feature.
    int add_vertex(const Vec3& at);
    /// Returns the new vertex.
    int split(int a, int b, const Vec3& at);
    [[nodiscard]] bool can_flip(int a, int b) const;
    void flip(int a, int b);

  private:
    void replace(int t, int from, int to);
    void detach(int v, int t);

    std::vector<Vec3> points_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<std::array<int, 3>> curves_;
    std::vector<int> faces_;
    std::vector<int> corners_;
    std::vector<std::vector<int>> fans_;
};

/// Least height of a triangle over its longest side: 0.87 at best, 0 without area.
double shape_quality(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace patchwright::geom
