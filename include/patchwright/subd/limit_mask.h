// Points of the limit surface as linear combinations of control points, at any parameter.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/ring.h>

#include <memory>

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

/// Coefficients over a ring's slots: 1 x slots each.
struct RingMask {
    Eigen::RowVectorXd position;
    /// Derivatives along u and v; all zero where they do not exist (extraordinary points).
    Eigen::RowVectorXd du, dv;
};

/// @pre 0 <= u, v <= 1; `kind` is a quad's, or sector is below its size
/// Source: Stam (1998) in the form of repeated subdivision towards (u, v), then the bicubic basis.
RingMask ring_mask(const RingKind& kind, double u, double v, int sector = 0);

/// Coefficients over the vertices of a mesh; indices may repeat.
struct Mask {
    std::vector<std::int32_t> vertices;
    std::vector<double> weights;  ///< sum 1
};

/// Evaluates masks of one topology. Thread-safe.
class LimitEvaluator {
  public:
    explicit LimitEvaluator(std::shared_ptr<const mesh::Topology> topology);

    /// @throw InvalidArgument when the location is not on the mesh
    [[nodiscard]] Mask position_mask(const Location& at) const;
    [[nodiscard]] geom::Vec3 position(const geom::Points& points, const Location& at) const;

  private:
    std::shared_ptr<const mesh::Topology> topology_;
    std::unique_ptr<RingTable> table_;
};

/// Limit position of a control point.
geom::Vec3 limit_position(const mesh::Cage& cage, mesh::VertexId v);

}  // namespace patchwright::subd
