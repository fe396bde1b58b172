#include "cage/blocks/piece_blocks.h"

#include <patchwright/base/numbers.h>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Where the inner nodes of a lens, a drop and a disc are, as shares of the way from the middle of
// the flat piece to its border: so that all blocks of a template have about the same size there.
constexpr double lens_share = 0.4, drop_share = 0.45, disc_share = 0.5;
// Steps of the lines between nodes.
constexpr int steps_of_line = 8;

class Templates {
  public:
    Templates(QuadLayout& layout, const geom::ModelSurface& reference, const FlatBorder& border)
        : layout_(layout),
          reference_(reference),
          border_(border),
          piece_(int(layout.pieces.size()) - 1) {}

    void add(PieceForm form) {
        switch (form) {
            case PieceForm::Block: add_block(side(0), side(1), side(2), side(3)); return;
            case PieceForm::Polygon: add_polygon(); return;
            case PieceForm::Lens: add_lens(); return;
            case PieceForm::Drop: add_drop(); return;
            case PieceForm::Disc: add_disc(); return;
            case PieceForm::Sphere: throw LayoutRefused{"a face is closed in itself"};
        }
    }

  private:
    /// A node with its place on the flat piece.
    struct NodeSpot {
        int node;
        Vec2 flat;
    };

    [[nodiscard]] const FlatSide& side(int k) const {
        return border_.sides[at(k) % border_.sides.size()];
    }
    [[nodiscard]] NodeSpot stop(int k) const {
        const std::size_t i = at(k) % border_.nodes.size();
        return {border_.nodes[i], border_.polygon[i]};
    }

    [[nodiscard]] Vec3 on_model(const Vec2& p) const {
        const FlatPiece::SurfacePoint place = layout_.pieces[at(piece_)].at(p);
        return reference_.foot_point(place.point, place.normal).point;
    }

    NodeSpot spot(const Vec2& flat) {
        LayoutNode node;
        node.point = on_model(flat);
        node.held = false;
        layout_.nodes.push_back(node);
        return {int(layout_.nodes.size()) - 1, flat};
    }

    FlatSide line(const NodeSpot& from, const NodeSpot& to) {
        LayoutArc arc;
        arc.start = from.node;
        arc.end = to.node;
        arc.piece = piece_;
        arc.from = from.flat;
        arc.to = to.flat;
        arc.points.push_back(layout_.nodes[at(from.node)].point);
        for (int k = 1; k < steps_of_line; ++k)
            arc.points.push_back(
                on_model(from.flat + (to.flat - from.flat) * (double(k) / steps_of_line)));
        arc.points.push_back(layout_.nodes[at(to.node)].point);
        layout_.arcs.push_back(std::move(arc));
        return {{{int(layout_.arcs.size()) - 1, false}}, {from.flat}, to.flat};
    }

    void add_block(const FlatSide& a, const FlatSide& b, const FlatSide& c, const FlatSide& d) {
        LayoutBlock block;
        block.piece = piece_;
        block.sides = {a.arcs, b.arcs, c.arcs, d.arcs};
        block.flat = {a.flat, b.flat, c.flat, d.flat};
        layout_.blocks.push_back(std::move(block));
    }

    void add_polygon() {
        const NodeSpot middle = spot(Vec2::Zero());
        const int count = int(border_.nodes.size()) / 2;
        std::vector<FlatSide> spokes;  // from the middles of the sides inward
        for (int k = 0; k < count; ++k) spokes.push_back(line(stop(2 * k + 1), middle));
        for (int k = 0; k < count; ++k)
            add_block(side(2 * k), spokes[at(k)], reversed(spokes[at((k + count - 1) % count)]),
                      side(2 * k + 2 * count - 1));
    }

    /// Corner 0, splits 1 and 2, corner 3, splits 4 and 5.
    void add_lens() {
        const NodeSpot p = spot(lens_share * stop(0).flat), q = spot(lens_share * stop(3).flat);
        const FlatSide p1 = line(p, stop(1)), p5 = line(p, stop(5)), q2 = line(q, stop(2)),
                       q4 = line(q, stop(4)), pq = line(p, q);
        add_block(side(0), reversed(p1), p5, side(5));
        add_block(side(1), reversed(q2), reversed(pq), p1);
        add_block(side(2), side(3), reversed(q4), q2);
        add_block(pq, q4, side(4), reversed(p5));
    }

    /// Corner 0, splits 1 to 4; the triangle inside has a vertex in its middle.
    void add_drop() {
        const std::array<NodeSpot, 3> ring{spot(drop_share * stop(0).flat),
                                           spot(drop_share * stop(2).flat),
                                           spot(drop_share * stop(3).flat)};
        const Vec2 centre = (ring[0].flat + ring[1].flat + ring[2].flat) / 3.0;
        const NodeSpot middle = spot(centre);
        std::array<FlatSide, 3> first, second, spoke;  // from a ring's spot to the next, inward
        for (std::size_t k = 0; k < 3; ++k) {
            const NodeSpot& next = ring[(k + 1) % 3];
            const NodeSpot half = spot(0.5 * (ring[k].flat + next.flat));
            first[k] = line(ring[k], half);
            second[k] = line(half, next);
            spoke[k] = line(half, middle);
        }
        const auto joined = [](FlatSide a, const FlatSide& b) {
            a.arcs.insert(a.arcs.end(), b.arcs.begin(), b.arcs.end());
            a.flat.insert(a.flat.end(), b.flat.begin(), b.flat.end());
            a.end = b.end;
            return a;
        };
        const FlatSide s1 = line(stop(1), ring[0]), s2 = line(stop(2), ring[1]),
                       s3 = line(stop(3), ring[2]), s4 = line(stop(4), ring[0]);
        add_block(side(0), s1, reversed(s4), side(4));
        add_block(side(1), s2, reversed(joined(first[0], second[0])), reversed(s1));
        add_block(side(2), s3, reversed(joined(first[1], second[1])), reversed(s2));
        add_block(side(3), s4, reversed(joined(first[2], second[2])), reversed(s3));
        for (std::size_t k = 0; k < 3; ++k)
            add_block(first[k], spoke[k], reversed(spoke[(k + 2) % 3]), second[(k + 2) % 3]);
    }

    void add_disc() {
        std::vector<NodeSpot> ring;
        std::vector<FlatSide> spokes, inside;
        for (int k = 0; k < 4; ++k) {
            ring.push_back(spot(disc_share * stop(k).flat));
            spokes.push_back(line(stop(k), ring.back()));
        }
        for (int k = 0; k < 4; ++k) inside.push_back(line(ring[at(k)], ring[at((k + 1) % 4)]));
        for (int k = 0; k < 4; ++k)
            add_block(side(k), spokes[at((k + 1) % 4)], reversed(inside[at(k)]),
                      reversed(spokes[at(k)]));
        add_block(inside[0], inside[1], inside[2], inside[3]);
    }

    QuadLayout& layout_;
    const geom::ModelSurface& reference_;
    const FlatBorder& border_;
    int piece_;
};

}  // namespace

FlatSide reversed(const FlatSide& side) {
    FlatSide result;
    for (std::size_t i = side.arcs.size(); i-- > 0;) {
        result.arcs.push_back({side.arcs[i].arc, !side.arcs[i].reversed});
        result.flat.push_back(i + 1 < side.flat.size() ? side.flat[i + 1] : side.end);
    }
    result.end = side.flat.front();
    return result;
}

void add_piece_blocks(QuadLayout& layout, const geom::ModelSurface& reference, PieceForm form,
                      const FlatBorder& border) {
    Templates(layout, reference, border).add(form);
}

}  // namespace patchwright::cage
