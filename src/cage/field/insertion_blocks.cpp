#include "cage/blocks/piece_blocks.h"
#include "cage/field/whole_blocks.h"
#include "geom/polyline.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Of a side of a triangle: an arc is not parted nearer to its ends, as what is shorter than a
// triangle's rounding has no place in it.
constexpr double nearest = 1e-2;

/// Where an arc is parted.
struct Stop {
    std::size_t segment;  ///< between this one of its points and the next
    double t;             ///< share of the segment
    Vec3 point;
    double share;  ///< of the arc
};
using Stops = std::map<int, Stop>;  ///< of one arc, by the number of its edges before

class Insertions {
  public:
    Insertions(QuadLayout& layout, Divisions& divisions) : layout_(layout), divisions_(divisions) {}

    void part() {
        find_stops();
        for (LayoutBlock& block : layout_.blocks) part_border(block);
        for (const auto& [a, stops] : stops_) part_arc(a, stops);
        for (LayoutBlock& block : layout_.blocks) part_sides(block);
        const int count = int(layout_.blocks.size());
        for (int b = 0; b < count; ++b)
            if (divisions_.insertions[at(b)].count > 0) add_blocks(b);
    }

  private:
    [[nodiscard]] int edges(int arc) const { return divisions_.edges[at(arc)]; }
    [[nodiscard]] int edges(const BlockSide& side) const { return edges_of(side, divisions_); }

    void find_stops() {
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
            const auto [s, count] = divisions_.insertions[b];
            if (count == 0) continue;
            const auto& sides = layout_.blocks[b].sides;
            add_stop(sides[at(s)], count);
            add_stop(sides[at((s + 1) % 4)], edges(sides[at((s + 1) % 4)]) - count);
        }
    }

    void add_stop(const BlockSide& side, int edge) {
        for (const ArcUse& use : side) {
            const int n = edges(use.arc);
            if (edge > 0 && edge < n) {
                const int k = use.reversed ? n - edge : edge;
                stops_[use.arc].emplace(k, stop_at(layout_.arcs[at(use.arc)], double(k) / n));
            }
            edge -= n;
        }
    }

    [[nodiscard]] static std::vector<double> shares(const LayoutArc& arc) {
        return arc.shares.size() == arc.points.size() ? arc.shares
                                                      : geom::arc_length_shares(arc.points);
    }

    [[nodiscard]] static Stop stop_at(const LayoutArc& arc, double share) {
        const std::vector<double> at_points = shares(arc);
        std::size_t i = 0;
        while (i + 2 < at_points.size() && at_points[i + 1] <= share) ++i;
        const double step = at_points[i + 1] - at_points[i];
        const double t = std::clamp((share - at_points[i]) / step, nearest, 1.0 - nearest);
        return {i, t, arc.points[i] + t * (arc.points[i + 1] - arc.points[i]),
                at_points[i] + t * step};
    }

    // Pieces.

    /// Puts the stops into a line of vertices along an arc; parts it there.
    static std::vector<std::vector<int>> parted(CutDisc& disc, const std::vector<int>& line,
                                                const Stops& stops) {
        std::vector<std::vector<int>> parts(1);
        auto stop = stops.begin();
        for (std::size_t i = 0; i < line.size(); ++i) {
            parts.back().push_back(line[i]);
            double before = 0.0;
            for (; stop != stops.end() && stop->second.segment == i; ++stop) {
                const double t = (stop->second.t - before) / (1.0 - before);
                before = stop->second.t;
                const int m = disc.split(parts.back().back(), line[i + 1], t, stop->second.point);
                parts.back().push_back(m);
                parts.push_back({m});
            }
        }
        return parts;
    }

    /// Splits triangles of a block where arcs around it are parted.
    void part_border(LayoutBlock& block) {
        int border = 0;
        bool any = false;
        for (const BlockSide& side : block.sides) {
            for (const ArcUse& use : side) {
                border += int(layout_.arcs[at(use.arc)].points.size()) - 1;
                any = any || stops_.contains(use.arc);
            }
        }
        if (!any) return;
        CutDisc disc(layout_.pieces[at(block.piece)], border);
        BlockLoop loop;
        int place = *block.first_point;
        for (std::size_t s = 0; s < 4; ++s) {
            for (const ArcUse& use : block.sides[s]) {
                std::vector<int> line;
                const int last = int(layout_.arcs[at(use.arc)].points.size()) - 1;
                for (int k = 0; k <= last; ++k) line.push_back((place + k) % border);
                place += last;
                if (use.reversed) std::reverse(line.begin(), line.end());
                const auto stops = stops_.find(use.arc);
                auto parts = parted(disc, line, stops == stops_.end() ? Stops() : stops->second);
                if (use.reversed) {
                    std::reverse(parts.begin(), parts.end());
                    for (auto& part : parts) std::reverse(part.begin(), part.end());
                }
                for (auto& part : parts) {
                    part.pop_back();
                    loop[s].push_back(std::move(part));
                }
            }
        }
        set_piece(layout_, block, disc, loop);
    }

    // Arcs.

    /// The arc becomes its first part; others come last in the layout.
    void part_arc(int a, const Stops& stops) {
        const LayoutArc whole = layout_.arcs[at(a)];
        const std::vector<double> at_points = shares(whole);
        const int count = edges(a);
        std::vector<LayoutArc> parts;
        std::vector<int> numbers;
        const auto begin = [&](int node, const Vec3& point, double share) {
            LayoutArc& part = parts.emplace_back(whole);
            part.start = node;
            part.points = {point};
            part.shares = {share};
        };
        const auto end = [&](int node, const Vec3& point, double share) {
            LayoutArc& part = parts.back();
            part.end = node;
            part.points.push_back(point);
            part.shares.push_back(share);
            const double first = part.shares.front(), length = share - first;
            for (double& x : part.shares) x = (x - first) / length;
        };
        begin(whole.start, whole.points[0], 0.0);
        auto stop = stops.begin();
        int before = 0;
        for (std::size_t i = 0; i + 1 < whole.points.size(); ++i) {
            if (i > 0) {
                parts.back().points.push_back(whole.points[i]);
                parts.back().shares.push_back(at_points[i]);
            }
            for (; stop != stops.end() && stop->second.segment == i; ++stop) {
                const auto& [edge, s] = *stop;
                const int node = int(layout_.nodes.size());
                layout_.nodes.push_back({s.point, whole.curve >= 0, whole.curve, false});
                end(node, s.point, s.share);
                begin(node, s.point, s.share);
                numbers.push_back(edge - before);
                before = edge;
            }
        }
        end(whole.end, whole.points.back(), 1.0);
        numbers.push_back(count - before);
        for (std::size_t k = 0; k < parts.size(); ++k) {
            if (whole.shares.empty()) parts[k].shares.clear();
            const int number = k == 0 ? a : int(layout_.arcs.size());
            if (k > 0) {
                layout_.arcs.emplace_back();
                divisions_.edges.push_back(0);
            }
            layout_.arcs[at(number)] = std::move(parts[k]);
            divisions_.edges[at(number)] = numbers[k];
            parts_[a].push_back(number);
        }
    }

    void part_sides(LayoutBlock& block) const {
        for (BlockSide& side : block.sides) {
            BlockSide result;
            for (const ArcUse& use : side) {
                const auto found = parts_.find(use.arc);
                std::vector<int> arcs =
                    found == parts_.end() ? std::vector<int>{use.arc} : found->second;
                if (use.reversed) std::reverse(arcs.begin(), arcs.end());
                for (const int a : arcs) result.push_back({a, use.reversed});
            }
            side = std::move(result);
        }
    }

    // Blocks.

    [[nodiscard]] int node_at(const ArcUse& use) const {
        const LayoutArc& arc = layout_.arcs[at(use.arc)];
        return use.reversed ? arc.end : arc.start;
    }

    /// The two parts of a side, of which the first one has a number of edges.
    [[nodiscard]] std::pair<FlatSide, FlatSide> parted(const FlatSide& side, int count) const {
        std::pair<FlatSide, FlatSide> result;
        for (std::size_t i = 0; i < side.arcs.size(); ++i) {
            FlatSide& part = count > 0 ? result.first : result.second;
            part.arcs.push_back(side.arcs[i]);
            part.flat.push_back(side.flat[i]);
            count -= edges(side.arcs[i].arc);
        }
        if (count != -edges(result.second.arcs) || result.first.arcs.empty())
            throw LayoutRefused{"sides of a block do not meet"};
        result.first.end = result.second.flat.front();
        result.second.end = side.end;
        return result;
    }

    /// A straight line to an inner node.
    FlatSide line(const FlatSide& from, int node, const Vec2& to, int count, int piece) {
        LayoutArc arc;
        arc.start = node_at(from.arcs.front());
        arc.end = node;
        arc.piece = piece;
        arc.from = from.flat.front();
        arc.to = to;
        layout_.arcs.push_back(arc);
        divisions_.edges.push_back(count);
        return {{{int(layout_.arcs.size()) - 1, false}}, {arc.from}, to};
    }

    /// Corners a, b, c, d; strips go around b, and a line leads from d to the middle.
    void add_blocks(int b) {
        const auto [s, count] = divisions_.insertions[at(b)];
        const LayoutBlock block = layout_.blocks[at(b)];
        std::array<FlatSide, 4> side;
        for (int k = 0; k < 4; ++k)
            side[at(k)] = {block.sides[at((s + k) % 4)], block.flat[at((s + k) % 4)],
                           block.flat[at((s + k + 1) % 4)].front()};
        const auto& [ab, bc, cd, da] = side;
        const int of_cd = edges(cd.arcs), of_da = edges(da.arcs);
        const auto [am, mb] = parted(ab, count);
        const auto [bq, qc] = parted(bc, of_da);
        const Vec2 middle = (mb.flat[0] + qc.flat[0] + da.flat[0]) / 3.0;
        const int node = int(layout_.nodes.size());
        LayoutNode inner;
        inner.held = false;
        layout_.nodes.push_back(inner);
        const FlatSide mx = line(mb, node, middle, of_da, block.piece),
                       qx = line(qc, node, middle, of_cd, block.piece),
                       dx = line(da, node, middle, count, block.piece);
        divisions_.insertions[at(b)] = {};
        layout_.blocks[at(b)] = block_of(block.piece, {am, mx, reversed(dx), da});
        for (const auto& sides :
             {std::array{mb, bq, qx, reversed(mx)}, std::array{qc, cd, dx, reversed(qx)}}) {
            layout_.blocks.push_back(block_of(block.piece, sides));
            divisions_.insertions.emplace_back();
        }
    }

    static LayoutBlock block_of(int piece, const std::array<FlatSide, 4>& sides) {
        LayoutBlock block;
        block.piece = piece;
        for (std::size_t k = 0; k < 4; ++k) {
            block.sides[k] = sides[k].arcs;
            block.flat[k] = sides[k].flat;
        }
        return block;
    }

    QuadLayout& layout_;
    Divisions& divisions_;
    std::map<int, Stops> stops_;             ///< by arc
    std::map<int, std::vector<int>> parts_;  ///< of arcs, in their order
};

}  // namespace

void part_at_insertions(QuadLayout& layout, Divisions& divisions) {
    Insertions(layout, divisions).part();
    cut_shared_pieces(layout);
}

}  // namespace patchwright::cage
