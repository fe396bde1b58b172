#include "cage/field/ring_cuts.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::cage {

using base::at;

namespace {

// Pieces of a ring: each turns by a right angle then.
constexpr int pieces_of_ring = 4;
// Of the way between two cuts: how far a cut may be from its place to begin where a line ends.
constexpr double reach_of_nodes = 0.3;

/// A side of a border, with the region on its left.
struct BorderSide {
    int from = -1, to = -1;
};
using BorderLoop = std::vector<BorderSide>;

class RingFinder {
  public:
    explicit RingFinder(const LinedMesh& lined) : lined_(lined), mesh_(lined.mesh()) {}

    std::vector<LineStart> find() {
        std::vector<char> seen(at(mesh_.triangle_count()), 0);
        for (int seed = 0; seed < mesh_.triangle_count(); ++seed) {
            if (!mesh_.alive(seed) || seen[at(seed)] != 0) continue;
            std::vector<int> region{seed};
            seen[at(seed)] = 1;
            for (std::size_t i = 0; i < region.size(); ++i) {
                for (int k = 0; k < 3; ++k) {
                    if (lined_.is_wall(region[i], k)) continue;
                    const int u = across(mesh_, region[i], k);
                    if (seen[at(u)] != 0) continue;
                    seen[at(u)] = 1;
                    region.push_back(u);
                }
            }
            look_at(region);
        }
        return std::move(result_);
    }

  private:
    void look_at(const std::vector<int>& region) {
        const std::vector<BorderLoop> loops = loops_of(region);
        if (loops.size() != 2) return;
        std::set<int> inner, border;
        int points = 0;
        for (const BorderLoop& loop : loops) {
            points += int(loop.size());
            for (const BorderSide& s : loop) border.insert(s.from);
        }
        for (const int t : region)
            for (const int v : mesh_.triangle(t))
                if (!border.contains(v)) inner.insert(v);
        // Vertices less edges; triangles less edges on borders less others.
        const int n = int(region.size());
        if (points + int(inner.size()) - (3 * n - points) / 2 - points + n != 0) return;
        add_cuts(length(loops[0]) <= length(loops[1]) ? loops[0] : loops[1]);
    }

    [[nodiscard]] std::vector<BorderLoop> loops_of(const std::vector<int>& region) const {
        std::vector<BorderLoop> loops;
        std::set<std::pair<int, int>> walked;
        for (const int t : region) {
            for (int k = 0; k < 3; ++k) {
                if (!lined_.is_wall(t, k) || walked.contains({t, k})) continue;
                BorderLoop& loop = loops.emplace_back();
                int tri = t, side = k;
                while (walked.insert({tri, side}).second) {
                    const auto& c = mesh_.triangle(tri);
                    loop.push_back({c[at(side)], c[at((side + 1) % 3)]});
                    const int end = loop.back().to;
                    side = (side + 1) % 3;
                    while (!lined_.is_wall(tri, side)) {
                        tri = across(mesh_, tri, side);
                        side = mesh_.corner_of(tri, end);
                    }
                }
            }
        }
        return loops;
    }

    [[nodiscard]] double length_of(const BorderSide& s) const {
        return (mesh_.point(s.to) - mesh_.point(s.from)).norm();
    }
    [[nodiscard]] double length(const BorderLoop& loop) const {
        double sum = 0.0;
        for (const BorderSide& s : loop) sum += length_of(s);
        return sum;
    }

    [[nodiscard]] bool lines_end_at(int v) const {
        int walls = 0;
        for (const int t : mesh_.fan(v)) {
            const int k = mesh_.corner_of(t, v);
            walls += lined_.is_wall(t, k) ? 1 : 0;
        }
        return walls > 2;
    }

    void add_cuts(const BorderLoop& loop) {
        const double whole = length(loop), spacing = whole / pieces_of_ring;
        // The first one at a node, if there is one.
        const auto node = std::find_if(loop.begin(), loop.end(),
                                       [&](const BorderSide& s) { return lines_end_at(s.from); });
        const auto first = std::size_t(node == loop.end() ? 0 : node - loop.begin());
        for (int k = 0; k < pieces_of_ring; ++k) {
            double way = 0.0, least = 1e300;
            const BorderSide* best = nullptr;
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const BorderSide& s = loop[(first + i) % loop.size()];
                const double off = std::abs(way - k * spacing) / spacing;
                const double cost = off - (lines_end_at(s.from) ? reach_of_nodes : 0.0);
                way += length_of(s);
                if (cost >= least) continue;
                least = cost;
                best = &s;
            }
            add_cut(*best);
        }
    }

    void add_cut(const BorderSide& s) {
        const auto stops = [&](int a, int b) {
            return mesh_.is_feature(a, b) || lined_.is_line(a, b);
        };
        const VertexFan fan = fan_from(mesh_, s.from, s.to, stops);
        result_.push_back({s.from, lined_.direction_at(s.from, fan, 0.5 * fan.angle)});
    }

    const LinedMesh& lined_;
    const geom::EditableMesh& mesh_;
    std::vector<LineStart> result_;
};

}  // namespace

std::vector<LineStart> ring_cuts(const LinedMesh& lined) { return RingFinder(lined).find(); }

}  // namespace patchwright::cage
