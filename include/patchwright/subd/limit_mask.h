// Points of the limit surface as linear combinations of control points, at any parameter.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/ring.h>
#include <patchwright/subd/stencils.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace patchwright::subd {

/// A point of the limit surface. A quad has one parameter square, (0,0) at its first vertex, u
/// towards the second, v towards the fourth. Another polygon has one square a vertex ("sector", the
/// children of one subdivision step): (0,0) at that vertex, (1,1) at the face's middle.
struct Location {
    mesh::FaceId face;
    double u = 0.5;
    double v = 0.5;
    int sector = 0;  ///< 0 for quads
};

/// The place of a face's corner.
Location corner_location(const mesh::Topology& topology, mesh::CornerId c);

/// What exists at a point of the limit surface.
enum class Smoothness {
    Derivatives,   ///< first and second derivatives
    TangentPlane,  ///< extraordinary vertex: directions that span the tangent plane (of this face's
                   ///< side at a crease or corner), along u and v up to positive factors; where
                   ///< both sides leave on one line, only their cross product has a meaning
    Position       ///< not even those, or not asked for
};

/// Coefficients over a ring's slots.
struct RingMask {
    /// Position, d/du, d/dv, d2/du2, d2/dudv, d2/dv2: as many as asked for (1, 3 or 6) x slots.
    /// Rows of what does not exist are zero; with TangentPlane rows 1 and 2 are its directions.
    Eigen::MatrixXd rows;
    Smoothness smoothness = Smoothness::Derivatives;

    [[nodiscard]] auto position() const { return rows.row(0); }
};

/// @param order  of the highest derivatives: 0, 1 or 2
/// @pre 0 <= u, v <= 1; `kind` is a quad's, or sector is below its size
/// Source: Stam (1998) with stored powers of the subdivision matrix in place of its eigenvectors,
/// then the bicubic basis.
RingMask ring_mask(const RingKind& kind, double u, double v, int sector = 0, int order = 0);

/// Coefficients over the vertices of a mesh.
struct Mask {
    std::vector<std::int32_t> vertices;  ///< each once, rising
    Eigen::MatrixXd rows;                ///< as in RingMask, over `vertices`; sums 1, 0, 0, ...
    Smoothness smoothness = Smoothness::Derivatives;
};

/// The same point over the vertices of a coarser level: the product T S of masks and subdivision
/// matrix.
/// @pre stencils has a row for each of the mask's vertices
Mask relative_to_coarser(const Mask& mask, const Stencils& stencils);

/// A point of the limit surface.
struct LimitPoint {
    geom::Vec3 position = geom::Vec3::Zero();
    /// Directions only where smoothness is TangentPlane; else see there.
    geom::Vec3 du = geom::Vec3::Zero(), dv = geom::Vec3::Zero();
    /// Zero unless smoothness is Derivatives.
    geom::Vec3 duu = geom::Vec3::Zero(), duv = geom::Vec3::Zero(), dvv = geom::Vec3::Zero();
    geom::Vec3 normal = geom::Vec3::Zero();  ///< unit, along du x dv; zero where that vanishes
    Smoothness smoothness = Smoothness::Position;  ///< at least Position
};

/// Many locations as arrays that somebody else holds.
struct Locations {
    std::span<const std::int32_t> faces;
    std::span<const double> uv;             ///< u and v of the first one, of the second one, ...
    std::span<const std::int32_t> sectors;  ///< empty: all 0

    [[nodiscard]] std::size_t size() const { return faces.size(); }
    [[nodiscard]] Location operator[](std::size_t i) const {
        return {mesh::FaceId{faces[i]}, uv[2 * i], uv[2 * i + 1], sectors.empty() ? 0 : sectors[i]};
    }
};

/// Rows of masks and of points with derivatives up to this order: 1, 3 or 6.
constexpr int row_count(int order) { return order == 0 ? 1 : order == 1 ? 3 : 6; }

/// Evaluates masks and points of one topology. Thread-safe. Points are evaluated without
/// allocating, once the thread's buffers and the kinds of neighbourhoods it meets are there.
class LimitEvaluator {
  public:
    explicit LimitEvaluator(std::shared_ptr<const mesh::Topology> topology);

    /// @param order  of the highest derivatives: 0, 1 or 2
    /// @throw UsageError when the location is not on the mesh
    [[nodiscard]] Mask mask(const Location& at, int order = 0) const;
    [[nodiscard]] geom::Vec3 position(const geom::Points& points, const Location& at) const;
    /// Of a control point.
    [[nodiscard]] geom::Vec3 position(const geom::Points& points, mesh::VertexId v) const;
    /// @param order  of the highest derivatives that are wanted; others are zero
    [[nodiscard]] LimitPoint evaluate(const geom::Points& points, const Location& at,
                                      int order = 2) const;

    /// The rows of all masks, row_count(order) a location and in its order, on all threads. Indices
    /// of a row rise.
    /// @throw UsageError also when the arrays' sizes do not go together
    [[nodiscard]] Stencils masks(const Locations& at, int order = 0) const;
    /// The same rows of points: position, du, dv, ... of the first location, of the second one, ...
    /// @throw UsageError also when there is not one point a vertex
    [[nodiscard]] geom::Points evaluate(const geom::Points& points, const Locations& at,
                                        int order = 0) const;
    /// What exists at the locations; see LimitPoint::smoothness.
    [[nodiscard]] std::vector<Smoothness> smoothness(const Locations& at) const;

  private:
    void check(const Locations& at, int order) const;
    template <class Visit>
    void visit(const Locations& at, int order, const Visit& visit) const;
    void check(const Location& at) const;

    std::shared_ptr<const mesh::Topology> topology_;
    std::vector<std::uint8_t> smooth_;  // see smooth_valences() of ring_extractor.h
    std::unique_ptr<RingTable> table_;
};

/// Limit position of a control point. Of many of a cage: LimitEvaluator, made once.
geom::Vec3 limit_position(const mesh::Cage& cage, mesh::VertexId v);

}  // namespace patchwright::subd
#pragma GCC visibility pop
