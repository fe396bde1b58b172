#include "cage/field/whole_blocks.h"

#include "cage/field/cut_disc.h"
#include "geom/polyline.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

int last_point(const LayoutArc& arc) { return int(arc.points.size()) - 1; }

/// The blocks of one piece, and the lines between them.
class SharedPiece {
  public:
    SharedPiece(QuadLayout& layout, int piece, std::vector<int> blocks)
        : layout_(layout),
          piece_(piece),
          blocks_(std::move(blocks)),
          border_(border_count()),
          disc_(layout.pieces[at(piece)], border_) {}

    void cut() {
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a)
            if (layout_.arcs[a].piece == piece_) draw(int(a));
        // Before any of them is a piece of its own: their flat points are where they find arcs.
        std::vector<BlockLoop> loops;
        for (const int b : blocks_) loops.push_back(loop_of(layout_.blocks[at(b)]));
        for (std::size_t i = 0; i < blocks_.size(); ++i)
            set_piece(layout_, layout_.blocks[at(blocks_[i])], disc_, loops[i]);
    }

  private:
    [[nodiscard]] int border_count() const {
        int count = 0;
        for (const int b : blocks_)
            for (const BlockSide& side : layout_.blocks[at(b)].sides)
                for (const ArcUse& use : side)
                    if (layout_.arcs[at(use.arc)].piece != piece_)
                        count += last_point(layout_.arcs[at(use.arc)]);
        return count;
    }

    /// The border vertex at a place, which is that of a node; -1: none.
    [[nodiscard]] int border_vertex(const Vec2& p) const {
        constexpr double same_place = 1e-9;  // of a polygon within the unit circle
        for (int v = 0; v < border_; ++v)
            if ((disc_.flat(v) - p).norm() < same_place) return v;
        return -1;
    }

    int vertex_of(int node, const Vec2& p) {
        const int v = border_vertex(p);
        if (v >= 0) return v;
        const auto [it, added] = inner_.emplace(node, -1);
        if (added) {
            it->second = disc_.add_vertex(p);
            layout_.nodes[at(node)].point = disc_.point(it->second);
        }
        return it->second;
    }

    void draw(int a) {
        LayoutArc& arc = layout_.arcs[at(a)];
        const int from = vertex_of(arc.start, arc.from), to = vertex_of(arc.end, arc.to);
        const std::vector<int> path = disc_.draw(from, to);
        arc.points.clear();
        for (const int v : path) arc.points.push_back(disc_.point(v));
        arc.piece = -1;
        lines_[a] = path;
    }

    [[nodiscard]] std::vector<int> vertices_along(const ArcUse& use, const Vec2& from) const {
        const auto line = lines_.find(use.arc);
        std::vector<int> result;
        if (line != lines_.end()) {
            result = line->second;
            if (use.reversed) std::reverse(result.begin(), result.end());
            result.pop_back();
            return result;
        }
        const int first = border_vertex(from);
        if (first < 0) throw LayoutRefused{"arcs of a piece do not meet"};
        for (int k = 0; k < last_point(layout_.arcs[at(use.arc)]); ++k)
            result.push_back((first + k) % border_);
        return result;
    }

    [[nodiscard]] BlockLoop loop_of(const LayoutBlock& block) const {
        BlockLoop loop;
        for (std::size_t s = 0; s < 4; ++s)
            for (std::size_t i = 0; i < block.sides[s].size(); ++i)
                loop[s].push_back(vertices_along(block.sides[s][i], block.flat[s][i]));
        return loop;
    }

    QuadLayout& layout_;
    int piece_;
    std::vector<int> blocks_;
    int border_;
    CutDisc disc_;
    std::map<int, int> inner_;               ///< vertices of nodes
    std::map<int, std::vector<int>> lines_;  ///< vertices of arcs
};

/// Forgets pieces that no block has.
void tidy_pieces(QuadLayout& layout) {
    std::vector<int> number(layout.pieces.size(), -1);
    std::vector<FlatPiece> kept;
    for (LayoutBlock& block : layout.blocks) {
        int& n = number[at(block.piece)];
        if (n < 0) {
            n = int(kept.size());
            kept.push_back(std::move(layout.pieces[at(block.piece)]));
        }
        block.piece = n;
    }
    layout.pieces = std::move(kept);
}

}  // namespace

void set_piece(QuadLayout& layout, LayoutBlock& block, CutDisc& disc, const BlockLoop& loop) {
    constexpr std::array<std::array<double, 2>, 4> corners{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    std::vector<int> vertices;
    for (const auto& side : loop)
        for (const auto& arc : side) vertices.insert(vertices.end(), arc.begin(), arc.end());
    std::vector<Vec2> border;
    for (std::size_t s = 0; s < 4; ++s) {
        std::vector<Vec3> line;
        for (const auto& arc : loop[s])
            for (const int v : arc) line.push_back(disc.point(v));
        const std::size_t next = border.size() + line.size();
        line.push_back(disc.point(vertices[next % vertices.size()]));
        const std::vector<double> shares = geom::arc_length_shares(line);
        const Vec2 from(corners[s][0], corners[s][1]),
            to(corners[(s + 1) % 4][0], corners[(s + 1) % 4][1]);
        block.flat[s].clear();
        std::size_t place = 0;
        for (const auto& arc : loop[s]) {
            block.flat[s].emplace_back(from + shares[place] * (to - from));
            for (std::size_t k = 0; k < arc.size(); ++k)
                border.emplace_back(from + shares[place++] * (to - from));
        }
    }
    block.first_point = 0;
    block.piece = int(layout.pieces.size());
    layout.pieces.push_back(disc.piece(vertices, std::move(border)));
}

void cut_shared_pieces(QuadLayout& layout) {
    std::map<int, std::vector<int>> shared;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b)
        if (!layout.blocks[b].first_point) shared[layout.blocks[b].piece].push_back(int(b));
    for (const auto& [piece, blocks] : shared) SharedPiece(layout, piece, blocks).cut();
    tidy_pieces(layout);
}

}  // namespace patchwright::cage
