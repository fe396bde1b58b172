#include "cage/field/block_frames.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <array>

namespace patchwright::cage {

using base::at;

namespace {

ArcEnd end_out(int arc, const ArcPlace& u) { return {arc, u.reversed ? 1 : 0}; }
ArcEnd end_in(int arc, const ArcPlace& u) { return {arc, u.reversed ? 0 : 1}; }

}  // namespace

Vec2 turned(const Vec2& v, int quarters) {
    switch ((quarters % 4 + 4) % 4) {
        case 0: return v;
        case 1: return {-v.y(), v.x()};
        case 2: return -v;
        default: return {v.y(), -v.x()};
    }
}

BlockFrames::BlockFrames(const QuadLayout& layout, const Divisions& divisions)
    : layout_(layout), divisions_(divisions) {
    find_places();
    find_rigid();
    find_nodes();
}

void BlockFrames::find_places() {
    places_.resize(layout_.arcs.size());
    for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
        const LayoutBlock& block = layout_.blocks[b];
        std::array<int, 4> total{};
        for (int s = 0; s < 4; ++s) {
            for (std::size_t i = 0; i < block.sides[at(s)].size(); ++i) {
                const ArcUse& use = block.sides[at(s)][i];
                places_[at(use.arc)].push_back({int(b), s, int(i), total[at(s)], use.reversed});
                total[at(s)] += divisions_.edges[at(use.arc)];
            }
        }
        size_.emplace_back(double(total[0]), double(total[1]));
    }
}

void BlockFrames::find_rigid() {
    for (std::size_t a = 0; a < layout_.arcs.size(); ++a)
        rigid_.push_back(layout_.arcs[a].curve >= 0 || places_[a].size() != 2 ? 1 : 0);
}

Vec2 BlockFrames::origin(int arc, const ArcPlace& u) const {
    const Vec2& size = size_[at(u.block)];
    const Vec2 corner(u.side == 1 || u.side == 2 ? size.x() : 0.0, u.side >= 2 ? size.y() : 0.0);
    const double before = u.before + (u.reversed ? divisions_.edges[at(arc)] : 0);
    return corner + turned(Vec2(before, 0.0), u.side);
}

/// The place that comes before another one around a block.
ArcPlace BlockFrames::previous(const ArcPlace& u) const {
    const LayoutBlock& block = layout_.blocks[at(u.block)];
    const int side = u.place > 0 ? u.side : (u.side + 3) % 4;
    const int place = u.place > 0 ? u.place - 1 : int(block.sides[at(side)].size()) - 1;
    const auto& all = places_[at(block.sides[at(side)][at(place)].arc)];
    return *std::find_if(all.begin(), all.end(), [&](const ArcPlace& other) {
        return other.block == u.block && other.side == side && other.place == place;
    });
}

int BlockFrames::arc_of(const ArcPlace& u) const {
    return layout_.blocks[at(u.block)].sides[at(u.side)][at(u.place)].arc;
}

int BlockFrames::node_before(const ArcPlace& u) const {
    const LayoutArc& arc = layout_.arcs[at(arc_of(u))];
    return u.reversed ? arc.end : arc.start;
}

void BlockFrames::find_nodes() {
    freedom_.resize(layout_.nodes.size());
    std::vector<std::vector<ArcPlace>> at_node(layout_.nodes.size());
    for (const auto& places : places_)
        for (const ArcPlace& u : places) at_node[at(node_before(u))].push_back(u);
    for (std::size_t v = 0; v < at_node.size(); ++v) {
        const LayoutNode& node = layout_.nodes[v];
        if (node.corner || at_node[v].empty()) continue;
        if (node.held && node.curve < 0) continue;
        freedom_[v].free = free_of(int(v), at_node[v]);
    }
}

/// Carries the frame around the node; a node around which it comes back turned is singular.
int BlockFrames::free_of(int node, const std::vector<ArcPlace>& around) {
    auto& turn = freedom_[at(node)].turn;
    std::vector<ArcEnd> kept;  // ends of rigid arcs
    for (const ArcPlace& u : around) {
        const ArcPlace p = previous(u);
        for (const ArcEnd& end : {end_out(arc_of(u), u), end_in(arc_of(p), p)})
            if (rigid(end.first) && std::find(kept.begin(), kept.end(), end) == kept.end())
                kept.push_back(end);
    }
    if (!kept.empty() && kept.size() != 2) return 0;
    turn[kept.empty() ? end_out(arc_of(around[0]), around[0]) : kept[0]] = 0;
    for (std::size_t round = 0; round <= around.size(); ++round) {
        for (const ArcPlace& u : around) {
            const ArcPlace p = previous(u);
            const ArcEnd out = end_out(arc_of(u), u), in = end_in(arc_of(p), p);
            const int difference = quarters(p) - quarters(u);  // of `out` against `in`
            const auto known_out = turn.find(out), known_in = turn.find(in);
            if (known_in == turn.end()) {
                if (known_out != turn.end()) turn[in] = known_out->second - difference;
                continue;
            }
            const int t = known_in->second + difference;
            if (known_out == turn.end())
                turn[out] = t;
            else if ((t - known_out->second) % 4 != 0)
                return 0;
        }
    }
    for (const ArcPlace& u : around)
        if (!turn.contains(end_out(arc_of(u), u))) return 0;
    if (kept.empty()) return 2;
    return turn[kept[1]] % 2 == 0 ? 1 : 0;
}

}  // namespace patchwright::cage
