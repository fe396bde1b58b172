#include "cage/blocks/divisions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <queue>

namespace patchwright::cage {

namespace {

std::size_t at(int i) { return std::size_t(i); }

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A block's side that an arc is part of.
struct Place {
    int block = -1, side = -1;
};

/// A way of a strip: the arcs it crosses, and the corners of blocks that it turns around.
struct Strip {
    std::vector<int> arcs;
    std::vector<std::pair<int, int>> turns;  ///< block, side before the corner
};

class Divider {
  public:
    explicit Divider(const BlockLayout& layout)
        : layout_(layout), places_(layout.arcs.size()), turned_(layout.blocks.size(), -1) {
        result_.edges.assign(layout.arcs.size(), 0);
        result_.turns.resize(layout.blocks.size());
        for (std::size_t b = 0; b < layout.blocks.size(); ++b)
            for (int s = 0; s < 4; ++s)
                for (const ArcUse& use : layout.blocks[b].sides[at(s)])
                    places_[at(use.arc)].push_back({int(b), s});
        for (std::size_t a = 0; a < places_.size(); ++a)
            if (places_[a].empty() || places_[a].size() > 2)
                throw LayoutRefused{fmt::format("a line has {} blocks", places_[a].size())};
    }

    Divisions divide() {
        // What must be there, the scarcest first; every round adds one at least.
        for (int missing = most_missing(); missing >= 0; missing = most_missing()) {
            constexpr int tries = 20;
            bool added = false;
            for (int i = 0; i < tries && !added; ++i) {
                const auto strip = best_strip(missing, Turning::Anywhere);
                if (!strip) break;
                added = add(*strip);
            }
            if (!added) refuse(missing);
        }
        const int most_rounds = 20 * int(places_.size()) + 100;
        std::vector<char> settled(places_.size(), 0);
        for (int round = 0; round < most_rounds; ++round) {
            int scarcest = -1;
            double worst = 0.0;
            for (std::size_t a = 0; a < places_.size(); ++a) {
                const double lack = (wanted(int(a)) - number(int(a))) / wanted(int(a));
                if (settled[a] == 0 && lack > worst) {
                    worst = lack;
                    scarcest = int(a);
                }
            }
            if (scarcest < 0) break;
            const auto strip = best_strip(scarcest, Turning::WhereOthersDo);
            if (strip && gain(strip->arcs) > 0.0 && add(*strip))
                std::fill(settled.begin(), settled.end(), char(0));
            else
                settled[at(scarcest)] = 1;
        }
        return std::move(result_);
    }

  private:
    enum class Turning { WhereOthersDo, Anywhere };

    [[noreturn]] void refuse(int a) const {
        const auto& points = layout_.arcs[at(a)].points;
        const geom::Vec3 p = points.empty() ? geom::Vec3::Zero() : points[points.size() / 2];
        throw LayoutRefused{
            fmt::format("opposite sides of faces cannot get equal numbers of edges because of the "
                        "edge near ({:.4g}, {:.4g}, {:.4g})",
                        p.x(), p.y(), p.z())};
    }

    /// Takes a strip; false, and nothing is taken, when it turns around two corners of one block.
    bool add(const Strip& strip) {
        std::map<int, int> fresh;
        for (const auto& [block, side] : strip.turns) {
            const int before =
                result_.turns[at(block)].count > 0 ? result_.turns[at(block)].side : side;
            if (before == side && fresh.emplace(block, side).first->second == side) continue;
            turned_[at(block)] = result_.turns[at(block)].count > 0 ? before : fresh[block];
            return false;
        }
        for (const auto& [block, side] : strip.turns) {
            result_.turns[at(block)].side = side;
            ++result_.turns[at(block)].count;
            turned_[at(block)] = side;
        }
        for (const int a : strip.arcs) ++result_.edges[at(a)];
        return true;
    }

    [[nodiscard]] int number(int a) const { return result_.edges[at(a)]; }

    [[nodiscard]] double wanted(int a) const { return std::max(0.5, layout_.arcs[at(a)].wanted); }

    [[nodiscard]] int most_missing() const {
        int arc = -1, most = 0;
        for (std::size_t a = 0; a < places_.size(); ++a) {
            const int missing = layout_.arcs[a].least - number(int(a));
            if (missing > most) {
                most = missing;
                arc = int(a);
            }
        }
        return arc;
    }

    [[nodiscard]] double penalty(int a, int n) const {
        const double d = n - wanted(a);
        return d * d / wanted(a);
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
        constexpr double least = 0.02;
        const int n = number(a);
        if (n < layout_.arcs[at(a)].least) return least;
        return std::max(least, 0.5 + penalty(a, n + 1) - penalty(a, n));
    }

    /// States are arcs as entered on one of their two places.
    [[nodiscard]] static int state(int arc, int place) { return 2 * arc + place; }

    [[nodiscard]] std::optional<Strip> best_strip(int arc, Turning turning) const {
        if (auto closed = way(arc, 0, true, turning)) return closed;
        auto one = way(arc, 0, false, turning);
        if (!one || places_[at(arc)].size() == 1) return one;
        const auto two = way(arc, 1, false, turning);
        if (!two) return std::nullopt;
        one->arcs.insert(one->arcs.end(), two->arcs.begin() + 1, two->arcs.end());
        one->turns.insert(one->turns.end(), two->turns.begin(), two->turns.end());
        return one;
    }

    /// The cheapest way from an arc into one of its blocks and on, back to where it started or to
    /// an arc with one block only. The arc itself comes first.
    [[nodiscard]] std::optional<Strip> way(int arc, int place, bool closed, Turning turning) const {
        constexpr double first_turn = 12.0, further_turn = 0.5;
        const int start = state(arc, place);
        std::vector<double> length(2 * places_.size(), infinity);
        std::vector<int> from(2 * places_.size(), -1);
        std::vector<std::pair<int, int>> turn(2 * places_.size(), {-1, -1});
        using Item = std::pair<double, int>;
        std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
        length[at(start)] = 0.0;
        queue.emplace(0.0, start);
        double best = infinity;
        int last = -1, exit = -1;
        std::pair<int, int> last_turn{-1, -1};
        while (!queue.empty()) {
            const auto [l, s] = queue.top();
            queue.pop();
            if (l > length[at(s)] || l >= best) continue;
            const Place& in = places_[at(s / 2)][at(s % 2)];
            for (int step = 1; step <= 3; ++step) {
                const int side = (in.side + step) % 4;
                std::pair<int, int> corner{-1, -1};
                double extra = 0.0;
                if (step != 2) {
                    corner = {in.block, step == 1 ? in.side : side};
                    const int known = turned_[at(in.block)];
                    if (known >= 0 ? known != corner.second : turning != Turning::Anywhere)
                        continue;
                    const bool used = result_.turns[at(in.block)].count > 0;
                    if (!used && turning != Turning::Anywhere) continue;
                    extra = used ? further_turn : first_turn;
                }
                for (const ArcUse& use : layout_.blocks[at(in.block)].sides[at(side)]) {
                    const double next = l + extra + cost(use.arc);
                    const auto& places = places_[at(use.arc)];
                    if (places.size() == 1) {
                        if (closed || next >= best) continue;
                        best = next;
                        last = s;
                        exit = use.arc;
                        last_turn = corner;
                        continue;
                    }
                    // It leaves by the arc's other place; both may be of this block.
                    const int here = places[0].block == in.block && places[0].side == side ? 0 : 1;
                    const int onward = state(use.arc, 1 - here);
                    if (onward == start) {
                        if (!closed || next >= best) continue;
                        best = next;
                        last = s;
                        exit = -1;
                        last_turn = corner;
                        continue;
                    }
                    if (next >= length[at(onward)]) continue;
                    length[at(onward)] = next;
                    from[at(onward)] = s;
                    turn[at(onward)] = corner;
                    queue.emplace(next, onward);
                }
            }
        }
        if (last < 0) return std::nullopt;
        Strip strip;
        if (exit >= 0) strip.arcs.push_back(exit);
        if (last_turn.first >= 0) strip.turns.push_back(last_turn);
        for (int s = last; s >= 0; s = from[at(s)]) {
            strip.arcs.push_back(s / 2);
            if (turn[at(s)].first >= 0) strip.turns.push_back(turn[at(s)]);
        }
        std::reverse(strip.arcs.begin(), strip.arcs.end());
        return strip;
    }

    const BlockLayout& layout_;
    std::vector<std::vector<Place>> places_;
    std::vector<int> turned_;  ///< the only side after which strips may turn in a block; -1: any
    Divisions result_;
};

}  // namespace

Divisions divide_arcs(const BlockLayout& layout) { return Divider(layout).divide(); }

}  // namespace patchwright::cage
