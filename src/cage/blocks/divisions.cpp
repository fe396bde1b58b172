#include "cage/blocks/divisions.h"

#include "cage/blocks/division_costs.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace patchwright::cage {

using base::at;
using base::infinity;

namespace {

/// A corner of a block, by the side that ends there.
struct BlockCorner {
    int block = -1, side = -1;
};

/// A way of a strip: the arcs it crosses, and the corners of blocks that it goes around.
struct Strip {
    std::vector<int> arcs;
    std::vector<BlockCorner> corners;
};

// Strips that are tried for an arc that has too few edges: each failure rules out one corner.
constexpr int tries = 20;
// Strips that are added at most, besides those that must be: for each arc, and for small layouts.
constexpr int rounds_per_arc = 20, fewest_rounds = 100;
// A strip where edges are missing must still be short.
constexpr double least_cost = 0.02;
// Of each arc that a strip crosses, so that short ways are taken.
constexpr double cost_of_arc = 0.5;

class Divider {
  public:
    Divider(const QuadLayout& layout, Poll& poll, std::optional<Divisions> start)
        : layout_(layout),
          poll_(poll),
          uses_(layout.arcs.size()),
          corner_side_(layout.blocks.size(), -1) {
        if (start) {
            result_ = std::move(*start);
        } else {
            result_.edges.assign(layout.arcs.size(), 0);
            result_.insertions.resize(layout.blocks.size());
        }
        for (std::size_t b = 0; b < layout.blocks.size(); ++b)
            if (result_.insertions[b].count > 0) corner_side_[b] = result_.insertions[b].side;
        for (std::size_t b = 0; b < layout.blocks.size(); ++b)
            for (int s = 0; s < 4; ++s)
                for (const ArcUse& use : layout.blocks[b].sides[at(s)])
                    uses_[at(use.arc)].push_back({int(b), s});
        for (std::size_t a = 0; a < uses_.size(); ++a)
            if (uses_[a].empty() || uses_[a].size() > 2)
                throw LayoutRefused{fmt::format("a line has {} blocks", uses_[a].size())};
    }

    Divisions divide() {
        // What must be there, the scarcest first; every round adds one at least.
        for (int missing = most_missing(); missing >= 0; missing = most_missing()) {
            bool added = false;
            for (int i = 0; i < tries && !added; ++i) {
                const auto strip = best_strip(missing, Insertions::Anywhere);
                if (!strip) break;
                added = add(*strip);
            }
            if (!added) refuse(missing);
        }
        const int round_limit = rounds_per_arc * int(uses_.size()) + fewest_rounds;
        std::vector<char> settled(uses_.size(), 0);
        for (int round = 0; round < round_limit; ++round) {
            int scarcest = -1;
            double worst = 0.0;
            for (std::size_t a = 0; a < uses_.size(); ++a) {
                const double lack = (wanted(int(a)) - number(int(a))) / wanted(int(a));
                if (settled[a] == 0 && lack > worst) {
                    worst = lack;
                    scarcest = int(a);
                }
            }
            if (scarcest < 0) break;
            const auto strip = best_strip(scarcest, Insertions::WhereOthersAre);
            if (strip && gain(strip->arcs) > 0.0 && add(*strip))
                std::fill(settled.begin(), settled.end(), char(0));
            else
                settled[at(scarcest)] = 1;
        }
        return std::move(result_);
    }

  private:
    enum class Insertions { WhereOthersAre, Anywhere };

    [[noreturn]] void refuse(int a) const {
        const auto& points = layout_.arcs[at(a)].points;
        const geom::Vec3 p = points.empty() ? geom::Vec3::Zero() : points[points.size() / 2];
        throw LayoutRefused{
            fmt::format("opposite sides of faces cannot get equal numbers of edges because of the "
                        "edge near ({:.4g}, {:.4g}, {:.4g})",
                        p.x(), p.y(), p.z())};
    }

    /// Takes a strip; false, and nothing is taken, when it goes around two corners of one block.
    bool add(const Strip& strip) {
        std::map<int, int> fresh;
        for (const auto& [block, side] : strip.corners) {
            const Valence3Insertion& known = result_.insertions[at(block)];
            const int before = known.count > 0 ? known.side : side;
            if (before == side && fresh.emplace(block, side).first->second == side) continue;
            corner_side_[at(block)] = known.count > 0 ? before : fresh[block];
            return false;
        }
        for (const auto& [block, side] : strip.corners) {
            result_.insertions[at(block)].side = side;
            ++result_.insertions[at(block)].count;
            corner_side_[at(block)] = side;
        }
        for (const int a : strip.arcs) ++result_.edges[at(a)];
        return true;
    }

    [[nodiscard]] int number(int a) const { return result_.edges[at(a)]; }

    [[nodiscard]] double wanted(int a) const { return wanted_edges(layout_.arcs[at(a)]); }

    [[nodiscard]] int most_missing() const {
        int arc = -1, most = 0;
        for (std::size_t a = 0; a < uses_.size(); ++a) {
            const int missing = layout_.arcs[a].least - number(int(a));
            if (missing > most) {
                most = missing;
                arc = int(a);
            }
        }
        return arc;
    }

    [[nodiscard]] double penalty(int a, int n) const {
        return division_penalty(layout_.arcs[at(a)], n);
    }

    [[nodiscard]] double gain(const std::vector<int>& arcs) const {
        std::vector<int> sorted = arcs;
        std::sort(sorted.begin(), sorted.end());
        double sum = 0.0;
        for (std::size_t i = 0; i < sorted.size();) {
            std::size_t j = i;
            while (j < sorted.size() && sorted[j] == sorted[i]) ++j;
            const int a = sorted[i], n = number(a);
            sum += penalty(a, n) - penalty(a, n + int(j - i));
            i = j;
        }
        return sum;
    }

    /// Of one edge more, as a length of a way.
    [[nodiscard]] double cost(int a) const {
        const int n = number(a);
        if (n < layout_.arcs[at(a)].least) return least_cost;
        return std::max(least_cost, cost_of_arc + penalty(a, n + 1) - penalty(a, n));
    }

    /// States are arcs as entered by one of their two uses.
    [[nodiscard]] static int state(int arc, int use) { return 2 * arc + use; }

    [[nodiscard]] std::optional<Strip> best_strip(int arc, Insertions allowed) const {
        poll_();
        if (auto closed = way(arc, 0, true, allowed)) return closed;
        auto one = way(arc, 0, false, allowed);
        if (!one || uses_[at(arc)].size() == 1) return one;
        const auto two = way(arc, 1, false, allowed);
        if (!two) return std::nullopt;
        one->arcs.insert(one->arcs.end(), two->arcs.begin() + 1, two->arcs.end());
        one->corners.insert(one->corners.end(), two->corners.begin(), two->corners.end());
        return one;
    }

    /// How a strip may leave a block.
    struct Exit {
        int side = -1;
        BlockCorner corner;  ///< that it goes around; none when it leaves by the side opposite
        double cost = 0.0;
    };

    [[nodiscard]] std::vector<Exit> exits(const SideUse& in, Insertions allowed) const {
        std::vector<Exit> result;
        for (int step = 1; step <= 3; ++step) {
            const int side = (in.side + step) % 4;
            if (step == 2) {
                result.push_back({side, {}, 0.0});
                continue;
            }
            const BlockCorner corner{in.block, step == 1 ? in.side : side};
            const int known = corner_side_[at(in.block)];
            const bool used = result_.insertions[at(in.block)].count > 0;
            if (known >= 0 && known != corner.side) continue;
            if ((known < 0 || !used) && allowed != Insertions::Anywhere) continue;
            result.push_back({side, corner, used ? further_insertion : first_insertion});
        }
        return result;
    }

    /// Where a strip is that leaves a block by an arc: the arc's other use, which may be of the
    /// same block; -1 when it has one only.
    [[nodiscard]] int state_beyond(int arc, int block, int side) const {
        const auto& uses = uses_[at(arc)];
        if (uses.size() == 1) return -1;
        const int here = uses[0].block == block && uses[0].side == side ? 0 : 1;
        return state(arc, 1 - here);
    }

    /// The cheapest way from an arc into one of its blocks and on, back to where it started or to
    /// an arc with one block only. The arc itself comes first.
    [[nodiscard]] std::optional<Strip> way(int arc, int use, bool closed,
                                           Insertions allowed) const {
        const int start = state(arc, use);
        std::vector<BlockCorner> around(2 * uses_.size());  // gone around on the way into a state
        double best = infinity;
        int last = -1, last_arc = -1;
        BlockCorner last_corner;
        const auto visit = [&](int s, double length, const auto& reach) {
            if (length >= best) return;
            const SideUse& in = uses_[at(s / 2)][at(s % 2)];
            for (const Exit& exit : exits(in, allowed)) {
                for (const ArcUse& out : layout_.blocks[at(in.block)].sides[at(exit.side)]) {
                    const double next = length + exit.cost + cost(out.arc);
                    const int onward = state_beyond(out.arc, in.block, exit.side);
                    if (onward >= 0 && onward != start) {
                        if (reach(onward, next)) around[at(onward)] = exit.corner;
                        continue;
                    }
                    if (closed != (onward == start) || next >= best) continue;
                    best = next;
                    last = s;
                    last_arc = closed ? -1 : out.arc;
                    last_corner = exit.corner;
                }
            }
        };
        const geom::ShortestPaths paths =
            geom::shortest_paths(2 * uses_.size(), {{start, 0.0}}, visit);
        if (last < 0) return std::nullopt;
        Strip strip;
        if (last_corner.block >= 0) strip.corners.push_back(last_corner);
        for (const int s : paths.path_to(last)) strip.arcs.push_back(s / 2);
        if (last_arc >= 0) strip.arcs.push_back(last_arc);
        for (int s = last; s >= 0; s = paths.from[at(s)])
            if (around[at(s)].block >= 0) strip.corners.push_back(around[at(s)]);
        return strip;
    }

    const QuadLayout& layout_;
    Poll& poll_;
    std::vector<std::vector<SideUse>> uses_;
    /// One a block: the side after which strips may go around the corner, no other; -1: any.
    std::vector<int> corner_side_;
    Divisions result_;
};

}  // namespace

Divisions divide_arcs(const QuadLayout& layout, Poll& poll, std::optional<Divisions> start) {
    return Divider(layout, poll, std::move(start)).divide();
}

}  // namespace patchwright::cage
