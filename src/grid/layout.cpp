#include "patch/layout.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/layout.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace patchwright::grid {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

namespace {

/// Borders of charts and groups, run on straight through all vertices that have four faces.
class Borders {
  public:
    Borders(const Topology& t, BlockCovering covering)
        : t_(t), is_border_(std::size_t(t.edge_count()), 0) {
        const auto patches =
            covering == BlockCovering::Faces ? patch::Covering::Faces : patch::Covering::Charts;
        for (const patch::Chart& chart : patch::cover(t, patches)) {
            for (int side = 0; side < 4; ++side) {
                for (const CornerId c : chart.side(t, side)) mark(t.edge(c));
            }
        }
        for (const EdgeId e : t.edges()) {
            const CornerId c = t.corner(e);
            if (t.is_boundary(e)) {
                mark(e);
            } else if (covering == BlockCovering::Groups &&
                       t.group(t.face(c)) != t.group(t.face(t.twin(c)))) {
                mark(e);
            }
        }
        // Where other than four faces meet, or two at a boundary, all of them are corners of
        // blocks.
        for (const VertexId v : t.vertices()) {
            const bool is_even = t.face_valence(v) == (t.is_boundary(v) ? 2 : 4);
            if (!is_even) mark_all(v);
        }
        run_on();
    }

    [[nodiscard]] const std::vector<char>& marks() const { return is_border_; }

  private:
    void mark(EdgeId e) {
        if (is_border_[e.index()] != 0) return;
        is_border_[e.index()] = 1;
        new_.push_back(e);
    }
    void mark_all(VertexId v) {
        CornerId c = t_.corner(v);
        const CornerId first = c;
        do {
            mark(t_.edge(c));
            c = t_.rotate(c);
        } while (c.valid() && c != first);
    }
    void run_on() {
        while (!new_.empty()) {
            const CornerId c = t_.corner(new_.back());
            new_.pop_back();
            for (const CornerId way : {c, t_.twin(c)}) {
                if (!way.valid()) continue;
                const CornerId on = patch::straight_on(t_, way);
                if (on.valid()) mark(t_.edge(on));
            }
        }
    }

    const Topology& t_;
    std::vector<char> is_border_;
    std::vector<EdgeId> new_;
};

std::string family_of(const Topology& t, const std::vector<CornerId>& cells) {
    std::set<int> groups;
    for (const CornerId c : cells) groups.insert(t.group(t.face(c)));
    std::string name;
    for (const int group : groups) {
        if (group < 0) continue;
        if (!name.empty()) name += '+';
        name += t.group_names()[std::size_t(group)];
    }
    return name.empty() ? "surface" : name;
}

void name_blocks(const Topology& t, std::vector<Block>& blocks) {
    std::map<std::string, int> count;
    for (Block& block : blocks) {
        block.family = family_of(t, block.cells);
        block.name = fmt::format("{} {}", block.family, ++count[block.family]);
    }
}

/// Numbers the sides of the rectangles; each is a whole side of its neighbour.
void connect(const std::vector<patch::Chart>& charts, BlockLayout& layout) {
    const Topology& t = *layout.cage.topology;
    std::vector<std::int32_t> edge_of(std::size_t(t.edge_count()), -1);
    for (std::size_t b = 0; b < charts.size(); ++b) {
        for (int side = 0; side < 4; ++side) {
            const std::vector<CornerId> run = charts[b].side(t, side);
            std::int32_t& number = edge_of[t.edge(run.front()).index()];
            const bool is_new = number < 0;
            if (is_new) {
                const auto next = static_cast<std::int32_t>(layout.edges.size());
                for (const CornerId c : run) edge_of[t.edge(c).index()] = next;
                layout.edges.push_back({run});
            }
            layout.blocks[b].sides[std::size_t(side)] = {{number, !is_new}};
        }
    }
}

/// The same block with what was side 1 as side 0.
Block turned(const Topology& t, const Block& block) {
    Block result = block;
    std::swap(result.columns, result.rows);
    for (int i = 0; i < result.columns; ++i) {
        for (int j = 0; j < result.rows; ++j) {
            result.cells[std::size_t(i) * std::size_t(result.rows) + std::size_t(j)] =
                t.next(block.cell(block.columns - 1 - j, i));
        }
    }
    std::rotate(result.sides.begin(), result.sides.begin() + 1, result.sides.end());
    return result;
}

/// Whether a side of one block is another's, whole.
bool is_same(const std::vector<BlockEdgeUse>& a, const std::vector<BlockEdgeUse>& b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.rbegin(),
                                              [](const BlockEdgeUse& x, const BlockEdgeUse& y) {
                                                  return x.edge == y.edge &&
                                                         x.reversed != y.reversed;
                                              });
}

struct SharedSide {
    int of_a = -1, of_b = -1;
};

std::optional<SharedSide> shared_side(const Block& a, const Block& b) {
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            if (is_same(a.sides[std::size_t(i)], b.sides[std::size_t(j)])) return SharedSide{i, j};
        }
    }
    return std::nullopt;
}

Block joined(const Topology& t, Block a, Block b, SharedSide shared) {
    int turns = 0;
    for (; (shared.of_a - turns + 4) % 4 != 1; ++turns) a = turned(t, a);
    for (int k = 0; (shared.of_b - k + 4) % 4 != 3; ++k) b = turned(t, b);
    a.cells.insert(a.cells.end(), b.cells.begin(), b.cells.end());
    a.columns += b.columns;
    a.sides[0].insert(a.sides[0].end(), b.sides[0].begin(), b.sides[0].end());
    a.sides[1] = b.sides[1];
    b.sides[2].insert(b.sides[2].end(), a.sides[2].begin(), a.sides[2].end());
    a.sides[2] = std::move(b.sides[2]);
    // As it lay before, so that i and j of the first block stay what they were.
    for (; turns % 4 != 0; ++turns) a = turned(t, a);
    if (a.family != b.family) a.family = family_of(t, a.cells);
    return a;
}

/// Leaves out edges that no block uses.
void drop_unused(BlockLayout& layout) {
    const auto places = edge_places(layout);
    std::vector<int> number(layout.edges.size(), -1);
    std::vector<BlockEdge> kept;
    for (std::size_t e = 0; e < layout.edges.size(); ++e) {
        if (places[e].empty()) continue;
        number[e] = static_cast<int>(kept.size());
        kept.push_back(std::move(layout.edges[e]));
    }
    layout.edges = std::move(kept);
    for (Block& block : layout.blocks) {
        for (auto& side : block.sides) {
            for (BlockEdgeUse& use : side) use.edge = number[std::size_t(use.edge)];
        }
    }
}

/// @pre the blocks share the side
void join_in_place(BlockLayout& layout, int a, int b, SharedSide shared) {
    layout.blocks[std::size_t(a)] =
        joined(*layout.cage.topology, std::move(layout.blocks[std::size_t(a)]),
               std::move(layout.blocks[std::size_t(b)]), shared);
    if (std::size_t(b) + 1 != layout.blocks.size()) {
        layout.blocks[std::size_t(b)] = std::move(layout.blocks.back());
    }
    layout.blocks.pop_back();
}

}  // namespace

BlockLayout make_layout(const mesh::Cage& cage, BlockCovering covering) {
    BlockLayout layout;
    layout.given = cage.topology;
    layout.cage = cage.topology->all_quads() ? cage : subd::refine(cage, 1);
    const Topology& t = *layout.cage.topology;
    const std::vector<patch::Chart> charts = patch::rectangles(t, Borders(t, covering).marks());
    for (const patch::Chart& chart : charts) {
        layout.blocks.push_back(
            {.columns = chart.columns, .rows = chart.rows, .cells = chart.cells});
    }
    name_blocks(t, layout.blocks);
    connect(charts, layout);
    return layout;
}

subd::Location place_in_face(const Topology& topology, CornerId cell, double i, double j) {
    const mesh::FaceId f = topology.face(cell);
    switch (cell.value - topology.corners(f)[0].value) {
        case 0: return {f, i, j};
        case 1: return {f, 1.0 - j, i};
        case 2: return {f, 1.0 - i, 1.0 - j};
        default: return {f, j, 1.0 - i};
    }
}

subd::Location place_on_given(const BlockLayout& layout, CornerId cell, double i, double j) {
    const subd::Location place = place_in_face(*layout.cage.topology, cell, i, j);
    if (layout.given == layout.cage.topology) return place;
    const auto [f, u, v, sector] = place;
    // Faces of the first refinement are the corners of the given cage, see subd::Refinement.
    const CornerId parent{f.value};
    const mesh::FaceId face = layout.given->face(parent);
    const int child = parent.value - layout.given->corners(face)[0].value;
    if (layout.given->size(face) != 4) return {face, u, v, child};
    const bool right = child == 1 || child == 2, top = child >= 2;
    return {face, 0.5 * (u + (right ? 1.0 : 0.0)), 0.5 * (v + (top ? 1.0 : 0.0))};
}

BlockLayout join(const BlockLayout& layout, int a, int b) {
    const int count = static_cast<int>(layout.blocks.size());
    if (a < 0 || b < 0 || a >= count || b >= count || a == b) {
        throw base::InvalidArgument(
            fmt::format("blocks {} and {} are not two of the {} there are", a, b, count));
    }
    const auto shared = shared_side(layout.blocks[std::size_t(a)], layout.blocks[std::size_t(b)]);
    if (!shared) {
        throw base::InvalidArgument(
            fmt::format("blocks {} and {} share no whole side; join others first", a, b));
    }
    BlockLayout result = layout;
    join_in_place(result, a, b, *shared);
    drop_unused(result);
    return result;
}

namespace {

/// Points inside blocks need not lie on the cage's lines: creases stay between blocks.
bool has_crease(const BlockLayout& layout, int edge) {
    const Topology& t = *layout.cage.topology;
    const auto& run = layout.edges[std::size_t(edge)].run;
    return std::any_of(run.begin(), run.end(),
                       [&](CornerId c) { return t.sharpness(t.edge(c)) > 0.0; });
}

}  // namespace

BlockLayout join_all(const BlockLayout& layout) {
    BlockLayout result = layout;
    for (;;) {
        struct Candidate {
            std::size_t length = 0;
            int a = -1, b = -1;
            SharedSide shared;
        } best;
        const auto places = edge_places(result);
        for (const auto& users : places) {
            if (users.size() != 2 || users[0].block == users[1].block) continue;
            const Block& a = result.blocks[std::size_t(users[0].block)];
            const Block& b = result.blocks[std::size_t(users[1].block)];
            const auto& side = a.sides[std::size_t(users[0].side)];
            if (a.family != b.family || !is_same(side, b.sides[std::size_t(users[1].side)])) {
                continue;
            }
            std::size_t length = 0;
            bool is_smooth = true;
            for (const BlockEdgeUse& use : side) {
                length += result.edges[std::size_t(use.edge)].run.size();
                is_smooth = is_smooth && !has_crease(result, use.edge);
            }
            if (is_smooth && length > best.length) {
                best = {length, users[0].block, users[1].block, {users[0].side, users[1].side}};
            }
        }
        if (best.length == 0) break;
        join_in_place(result, best.a, best.b, best.shared);
    }
    drop_unused(result);
    name_blocks(*result.cage.topology, result.blocks);
    return result;
}

std::vector<std::vector<EdgePlace>> edge_places(const BlockLayout& layout) {
    std::vector<std::vector<EdgePlace>> places(layout.edges.size());
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        for (int side = 0; side < 4; ++side) {
            const auto& uses = layout.blocks[b].sides[std::size_t(side)];
            for (std::size_t k = 0; k < uses.size(); ++k) {
                places[std::size_t(uses[k].edge)].push_back(
                    {static_cast<int>(b), side, static_cast<int>(k)});
            }
        }
    }
    return places;
}

bool is_crease(const BlockLayout& layout, int edge) {
    const Topology& t = *layout.cage.topology;
    const auto& run = layout.edges[std::size_t(edge)].run;
    return std::all_of(run.begin(), run.end(), [&](CornerId c) {
        return t.twin(c).valid() && t.sharpness(t.edge(c)) > 0.0;
    });
}

}  // namespace patchwright::grid
