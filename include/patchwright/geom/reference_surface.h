// What a fit needs to know of the shape it approximates: nearest points on it and on its features.
#pragma once

#include <patchwright/geom/features.h>
#include <patchwright/geom/types.h>

#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Nearest point of a surface to a query point.
struct FootPoint {
    Vec3 point = Vec3::Zero();
    Vec3 normal =
        Vec3::Zero();       ///< unit, outward; zero where the surface has none (degenerate point)
    double distance = 0.0;  ///< |query - point|, >= 0
    int face = -1;          ///< face of the model the point lies on
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();  ///< parameters of the point on that face, if any
};

/// Where faces meet, or one ends; numbers of faces as in FootPoint::face.
struct FaceBorder {
    /// Seen from outside, in the direction of the curve if there is one; -1: none there.
    int left = -1, right = -1;
    int curve = -1;  ///< number among Features::curves; -1: on none
};

struct SurfaceSample {
    Vec3 point, normal;
    int face;
    double weight;  ///< area that it stands for, mm^2; 0 on edges and vertices
};

/// A shape to be approximated. All functions are const, thread-safe and deterministic.
class ReferenceSurface {
  public:
    virtual ~ReferenceSurface() = default;

    [[nodiscard]] virtual Box3 bounds() const = 0;

    /// Nearest point of the (trimmed) surface. With `side` given, points whose normal n has
    /// n . side > 0 are preferred over nearer ones that face away, as thin parts need; where no
    /// such point is near, the answer is the plain nearest point.
    /// @pre `side`, when given, is a unit vector
    [[nodiscard]] virtual FootPoint foot_point(
        const Vec3& query, const std::optional<Vec3>& side = std::nullopt) const = 0;

    /// The same of some faces only. A shape that lists no face_borders() answers for all of it.
    /// @param faces  one a face: not 0 where the answer may lie
    [[nodiscard]] virtual FootPoint foot_point_on(
        const std::vector<char>& faces, const Vec3& query,
        const std::optional<Vec3>& side = std::nullopt) const;

    /// All borders of faces, in pieces, each face's one at least; none unless a shape says
    /// otherwise.
    [[nodiscard]] virtual std::vector<FaceBorder> face_borders() const;

    /// About `count` points all over the surface, for asking what lies near them; deterministic.
    /// None unless a shape says otherwise.
    [[nodiscard]] virtual std::vector<SurfaceSample> sample(int count) const;

    /// All feature curves and corners; none unless a shape says otherwise.
    [[nodiscard]] virtual const Features& features() const;

    /// Nearest point of curve number `curve`, or of the piece of it that is given.
    /// @throw InvalidArgument when there is no such curve or the piece is empty
    [[nodiscard]] virtual FeaturePoint nearest_on_curve(
        int curve, const Vec3& query, const std::optional<ArcRange>& within = std::nullopt) const;

    /// The point at this arc length; beyond the ends the end, on closed curves round and round.
    /// FeaturePoint::distance is 0.
    /// @throw InvalidArgument when there is no such curve
    [[nodiscard]] virtual FeaturePoint point_on_curve(int curve, double arc_length) const;
};

}  // namespace patchwright::geom
#pragma GCC visibility pop
