// A surface in pieces that are halved where it cannot be told yet whether they meet.
#pragma once

#include "measure/piece_meeting.h"

#include <patchwright/measure/self_intersection.h>

#include <array>
#include <optional>
#include <vector>

namespace patchwright::measure {

/// How the sides of a surface hang together.
struct Domain {
    std::array<double, 2> u{}, v{};
    bool closed_u = false, closed_v = false;  ///< the first side and the last are one curve
    /// Sides that are a point: u low, u high, v low, v high.
    std::array<bool, 4> is_point{};

    explicit Domain(const geom::BsplineSurface& surface);
    [[nodiscard]] bool on_side(const Extent& e, std::size_t side) const {
        return side < 2 ? e.u[side] == u[side] : e.v[side - 2] == v[side - 2];
    }
    /// Whether the rectangles have a point in common, also across closed sides.
    [[nodiscard]] bool touch(const Extent& a, const Extent& b) const;
};

class SurfacePieces {
  public:
    /// Numbers of two pieces; equal ones: a piece with itself.
    using Pair = std::array<int, 2>;
    enum class Next { Nothing, HalveFirst, HalveSecond };
    struct Outcome {
        Next next = Next::Nothing;
        std::optional<SelfIntersection> hit;
    };

    /// @pre `surface` outlives this
    /// @param resolution  see find_self_intersections()
    SurfacePieces(const geom::BsplineSurface& surface, double resolution);

    /// Pairs of spans that bounds of groups of them do not settle.
    [[nodiscard]] std::vector<Pair> candidates() const;
    [[nodiscard]] Outcome test(const Pair& pair) const;

    [[nodiscard]] const geom::BsplineSurface& surface() const { return surface_; }
    [[nodiscard]] int span_count() const { return span_count_; }
    [[nodiscard]] int spans_u() const { return span_count_ / int(spans_v_); }
    [[nodiscard]] int spans_v() const { return int(spans_v_); }
    /// The first ones are the spans, span (i, j) of u and v is i * spans_v() + j.
    [[nodiscard]] const BezierPiece& piece(int number) const {
        return pieces_[std::size_t(number)];
    }

    /// Makes the halves of these pieces, unless they are there.
    void halve(const std::vector<int>& pieces);
    /// The first half; the second has the next number. @pre halved
    [[nodiscard]] int half(int piece) const { return halves_[std::size_t(piece)]; }

  private:
    struct Node : Extent {
        int span = -1;  ///< of a leaf
        std::array<int, 2> child{-1, -1};
    };
    /// Apart: they do not meet but where they touch in the parameter plane. Joined: they touch
    /// there, and may meet elsewhere. Open: they do not touch there, and may meet.
    enum class Relation { Apart, Joined, Open };

    int build(std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1);
    void within(int number, std::vector<Pair>& pairs) const;
    void between(int first, int second, std::vector<Pair>& pairs) const;
    [[nodiscard]] Relation relation(const Extent& a, const Extent& b) const;
    [[nodiscard]] Outcome test(const BezierPiece& a, const BezierPiece& b) const;
    [[nodiscard]] std::optional<SelfIntersection> loop_at(const BezierPiece& a,
                                                          const BezierPiece& b) const;
    [[nodiscard]] bool is_loop(const PieceMeeting& hit) const;

    const geom::BsplineSurface& surface_;
    double resolution_;
    Domain domain_;
    SurfaceFrame frame_;
    std::size_t spans_v_ = 0;
    int span_count_ = 0;
    std::vector<BezierPiece> pieces_;  ///< spans, then halves
    std::vector<int> halves_;          ///< of each piece the first; -1: not made
    std::vector<Node> nodes_;          ///< groups of spans
};

}  // namespace patchwright::measure
