#include "cage/field/grid_vertices.h"

#include "cage/field/block_frames.h"
#include "cage/field/division_search.h"
#include "geom/disjoint_sets.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace patchwright::cage {

using base::at;

namespace {

int widest(const QuadLayout& layout, const std::vector<int>& arcs) {
    return *std::max_element(arcs.begin(), arcs.end(), [&](int a, int b) {
        return layout.arcs[at(a)].wanted < layout.arcs[at(b)].wanted;
    });
}

/// Two vertices that are one because an arc has no edges.
struct Merger {
    int a, b, arc;
};

/// A vertex for every node and every point within an arc, and which of them are one.
class Numbering {
  public:
    Numbering(const QuadLayout& layout, const Divisions& divisions)
        : layout_(layout), divisions_(divisions) {
        for (const LayoutNode& node : layout.nodes) curve_.push_back(node.curve);
        for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
            std::vector<int>& line = of_arc_.emplace_back();
            line.push_back(layout.arcs[a].start);
            for (int k = 1; k < divisions.edges[a]; ++k) {
                line.push_back(int(curve_.size()));
                curve_.push_back(layout.arcs[a].curve);
            }
            if (divisions.edges[a] > 0)
                line.push_back(layout.arcs[a].end);
            else
                mergers_.push_back({layout.arcs[a].start, layout.arcs[a].end, int(a)});
        }
        for (std::size_t b = 0; b < layout.blocks.size(); ++b)
            if (divisions.insertions[b].count == 0) add_block(layout.blocks[b]);
        sets_ = geom::DisjointSets(curve_.size());
        for (const Merger& m : mergers_) sets_.join(m.a, m.b);
    }

    [[nodiscard]] int count() const { return int(curve_.size()); }
    [[nodiscard]] int curve(int v) const { return curve_[at(v)]; }
    [[nodiscard]] const std::vector<std::vector<int>>& of_arc() const { return of_arc_; }
    [[nodiscard]] const std::vector<Merger>& mergers() const { return mergers_; }
    [[nodiscard]] int set_of(int v) { return sets_.find(v); }

  private:
    [[nodiscard]] std::vector<int> along(const BlockSide& side) const {
        std::vector<int> result;
        for (const ArcUse& use : side) {
            std::vector<int> line = of_arc_[at(use.arc)];
            if (use.reversed) std::reverse(line.begin(), line.end());
            if (divisions_.edges[at(use.arc)] > 0)
                result.insert(result.end(), line.begin(), line.end() - 1);
        }
        return result;
    }

    void add_block(const LayoutBlock& block) {
        for (std::size_t s = 0; s < 2; ++s) {
            if (edges_of(block.sides[s], divisions_) > 0) continue;
            std::vector<int> arcs;
            for (const std::size_t across : {s, s + 2})
                for (const ArcUse& use : block.sides[across]) arcs.push_back(use.arc);
            const int blame = widest(layout_, arcs);
            // Their first points are joined by the arcs without edges.
            const std::vector<int> one = along(block.sides[s + 1]);
            std::vector<int> two = along(block.sides[(s + 3) % 4]);
            std::reverse(two.begin(), two.end());
            for (std::size_t k = 1; k < one.size(); ++k)
                mergers_.push_back({one[k], two[k - 1], blame});
        }
    }

    const QuadLayout& layout_;
    const Divisions& divisions_;
    std::vector<int> curve_;
    std::vector<std::vector<int>> of_arc_;
    std::vector<Merger> mergers_;
    geom::DisjointSets sets_;
};

/// Looks for vertices that are one and must not be.
class Separator {
  public:
    Separator(const QuadLayout& layout, const Divisions& divisions)
        : layout_(layout),
          divisions_(divisions),
          numbering_(layout, divisions),
          stays_(at(numbering_.count()), 0),
          ways_(at(numbering_.count())) {
        const BlockFrames frames(layout, divisions);
        for (std::size_t v = 0; v < layout.nodes.size(); ++v)
            stays_[v] = frames.freedom(int(v)).free == 0 ? 1 : 0;
        for (const LayoutArc& arc : layout.arcs)
            if (arc.curve >= 0)
                for (const int v : {arc.start, arc.end}) ends_of_curves_.insert({v, arc.curve});
        for (const Merger& m : numbering_.mergers()) {
            ways_[at(m.a)].push_back({m.b, m.arc});
            ways_[at(m.b)].push_back({m.a, m.arc});
        }
    }

    std::map<int, int> run() {
        look_at_insertions();
        look_at_loops();
        look_at_sets();
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a) {
            const auto& line = numbering_.of_arc()[a];
            for (std::size_t k = 0; k + 1 < line.size(); ++k)
                if (numbering_.set_of(line[k]) == numbering_.set_of(line[k + 1]))
                    part(line[k], line[k + 1]);
        }
        return std::move(least_);
    }

  private:
    void raise(int arc) { least_[arc] = divisions_.edges[at(arc)] + 1; }

    void look_at_insertions() {
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
            if (divisions_.insertions[b].count == 0) continue;
            for (const int k : {2, 3}) {
                const BlockSide& side =
                    layout_.blocks[b].sides[at((divisions_.insertions[b].side + k) % 4)];
                std::vector<int> arcs;
                for (const ArcUse& use : side) arcs.push_back(use.arc);
                if (edges_of(side, divisions_) == 0) raise(widest(layout_, arcs));
            }
        }
    }

    void look_at_loops() {
        std::map<int, std::vector<int>> arcs_of;
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a)
            if (layout_.arcs[a].curve >= 0) arcs_of[layout_.arcs[a].curve].push_back(int(a));
        for (const auto& [curve, arcs] : arcs_of) {
            std::set<int> nodes;
            int edges = 0;
            for (const int a : arcs) {
                nodes.insert(layout_.arcs[at(a)].start);
                nodes.insert(layout_.arcs[at(a)].end);
                edges += divisions_.edges[at(a)];
            }
            if (nodes.size() == arcs.size() && edges < fewest_of_loop) raise(widest(layout_, arcs));
        }
    }

    void look_at_sets() {
        std::map<int, std::vector<int>> sets;
        for (int v = 0; v < numbering_.count(); ++v) sets[numbering_.set_of(v)].push_back(v);
        for (const auto& [first, members] : sets) {
            std::optional<int> anchor;
            for (const int v : members) {
                if (stays_[at(v)] == 0) continue;
                if (anchor) part(*anchor, v);
                anchor = v;
            }
            std::optional<int> on_curve;
            for (const int v : members) {
                const int curve = numbering_.curve(v);
                if (stays_[at(v)] != 0 || curve < 0) continue;
                if (anchor && !ends_of_curves_.contains({*anchor, curve})) part(*anchor, v);
                if (!anchor && on_curve && numbering_.curve(*on_curve) != curve) part(*on_curve, v);
                on_curve = v;
            }
        }
    }

    /// Two vertices that are one must not be.
    void part(int from, int to) {
        const auto visit = [&](int v, double length, const auto& reach) {
            for (const auto& [next, arc] : ways_[at(v)]) reach(next, length + 1.0);
        };
        const auto path =
            geom::shortest_paths(at(numbering_.count()), {{from, 0.0}}, visit).path_to(to);
        std::vector<int> arcs;
        for (std::size_t i = 0; i + 1 < path.size(); ++i)
            for (const auto& [next, arc] : ways_[at(path[i])])
                if (next == path[i + 1]) arcs.push_back(arc);
        raise(widest(layout_, arcs));
    }

    const QuadLayout& layout_;
    const Divisions& divisions_;
    Numbering numbering_;
    std::vector<char> stays_;
    struct Way {
        int to, arc;
    };
    std::vector<std::vector<Way>> ways_;
    std::set<std::pair<int, int>> ends_of_curves_;  ///< nodes and curves
    std::map<int, int> least_;
};

}  // namespace

std::vector<int> GridVertices::along(const BlockSide& side) const {
    std::vector<int> result;
    for (const ArcUse& use : side) {
        std::vector<int> line = of_arc[at(use.arc)];
        if (use.reversed) std::reverse(line.begin(), line.end());
        result.insert(result.end(), line.begin() + (result.empty() ? 0 : 1), line.end());
    }
    return result;
}

GridVertices grid_vertices(const QuadLayout& layout, const Divisions& divisions) {
    Numbering numbering(layout, divisions);
    GridVertices result;
    std::map<int, int> number;
    const auto number_of = [&](int v) {
        return number.emplace(numbering.set_of(v), int(number.size())).first->second;
    };
    for (std::size_t v = 0; v < layout.nodes.size(); ++v)
        result.of_node.push_back(number_of(int(v)));
    for (const auto& line : numbering.of_arc()) {
        auto& vertices = result.of_arc.emplace_back();
        for (const int v : line) vertices.push_back(number_of(v));
    }
    result.count = int(number.size());
    return result;
}

std::map<int, int> least_apart(const QuadLayout& layout, const Divisions& divisions) {
    return Separator(layout, divisions).run();
}

Divisions divisions_apart(QuadLayout& layout, Poll& poll) {
    std::optional<Divisions> divisions;
    while (true) {
        divisions =
            improved_divisions(layout, divide_arcs(layout, poll, std::move(divisions)), poll);
        const std::map<int, int> least = least_apart(layout, *divisions);
        if (least.empty()) return *divisions;
        for (const auto& [arc, edges] : least) layout.arcs[at(arc)].least = edges;
    }
}

}  // namespace patchwright::cage
