// The limit surface over one face, for many points.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/ring.h>

#include <array>
#include <vector>

namespace patchwright::grid {

/// Holds the bicubic pieces that points have been asked for, so that the next one costs a
/// polynomial. One a thread. Equal points for equal parameters, in whatever order they are asked
/// for.
class LimitFace {
  public:
    /// @pre the face is a quad; table and points outlive this
    LimitFace(subd::RingTable& table, const mesh::Cage& cage, mesh::FaceId face);

    /// @pre 0 <= u, v <= 1
    [[nodiscard]] geom::Vec3 at(double u, double v);

    struct Tangents {
        geom::Vec3 point, du, dv;
    };
    /// The same point with its derivatives; at an extraordinary vertex, where there are none,
    /// directions in their place, or zero.
    [[nodiscard]] Tangents tangents(double u, double v);

  private:
    struct Node {
        const subd::RingKind* kind = nullptr;
        /// Control points: of the uniform bicubic B-spline for regular kinds, else of the ring.
        geom::Points control;
        std::array<std::int32_t, 4> child{-1, -1, -1, -1};
    };
    /// The piece that holds a point, and the point's place in it.
    struct Piece {
        std::size_t node;
        double u, v;
        double scale;  ///< of derivatives by the piece's parameters
    };
    [[nodiscard]] Piece piece_at(double u, double v);
    [[nodiscard]] Node make_node(const subd::RingKind& kind, geom::Points control) const;

    std::vector<Node> nodes_;
};

}  // namespace patchwright::grid
