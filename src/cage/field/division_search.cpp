#include "cage/field/division_search.h"

#include "cage/blocks/division_costs.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace patchwright::cage {

using base::at;
using base::infinity;

namespace {

// Of every step, so that ways are short, and what a change must gain.
constexpr double cost_of_step = 1e-4, worth_a_change = 1e-6;
// Passes over all steps between looks for a cycle.
constexpr int passes_between = 3;

/// Signs with which an insertion at a corner adds to side 0 less side 2, and to side 1 less side 3.
constexpr std::array<std::array<int, 2>, 4> corner_signs{{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

double penalty(const LayoutArc& arc, int n) { return division_penalty(arc, n); }

/// Length over width.
double slenderness(const QuadLayout& layout, const LayoutBlock& block) {
    std::array<double, 2> length{};
    for (std::size_t s = 0; s < 4; ++s) {
        for (const ArcUse& use : block.sides[s]) {
            const auto& points = layout.arcs[at(use.arc)].points;
            for (std::size_t i = 0; i + 1 < points.size(); ++i)
                length[s % 2] += (points[i + 1] - points[i]).norm();
        }
    }
    const double least = std::min(length[0], length[1]);
    return least > 0.0 ? std::max(length[0], length[1]) / least : 1.0;
}

class DivisionSearch {
  public:
    DivisionSearch(const QuadLayout& layout, Divisions valid, Poll& poll)
        : layout_(layout), current_(std::move(valid)), poll_(poll), uses_(layout.arcs.size()) {
        for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
            slenderness_.push_back(slenderness(layout, layout.blocks[b]));
            for (int s = 0; s < 4; ++s)
                for (const ArcUse& use : layout.blocks[b].sides[at(s)])
                    uses_[at(use.arc)].push_back({int(b), s});
        }
        steps_.resize(at(hub() + 1));
        banned_.assign(at(hub() + 1), 0);
    }

    Divisions run() {
        while (improve()) poll_();
        return std::move(current_);
    }

  private:
    struct Turn {
        int block = -1, corner = 0, change = 0;  ///< block -1: none
    };
    /// A change of an arc's number by +1 or -1, on its way into the block of one of its uses.
    struct Step {
        int to = -1;
        double cost = 0.0;
        Turn turn;
        int arc = -1, change = 0;
    };

    /// Where ways begin and end that lead from an arc with one block to another one.
    [[nodiscard]] int hub() const { return 4 * int(uses_.size()); }
    [[nodiscard]] static int state(int arc, int use, int change) {
        return 4 * arc + 2 * use + (change > 0 ? 1 : 0);
    }

    [[nodiscard]] double cost_of(int arc, int change) const {
        const LayoutArc& a = layout_.arcs[at(arc)];
        const int n = current_.edges[at(arc)];
        if (n + change < a.least) return infinity;
        return cost_of_step + penalty(a, n + change) - penalty(a, n);
    }

    [[nodiscard]] double cost_of(const Turn& turn) const {
        const Valence3Insertion& known = current_.insertions[at(turn.block)];
        // Lines that go around a corner of a slender block are far from straight across it.
        const double factor = slenderness_[at(turn.block)];
        if (turn.change > 0) {
            if (known.count == 0) return factor * first_insertion;
            return known.side == turn.corner ? factor * further_insertion : infinity;
        }
        if (known.count == 0 || known.side != turn.corner) return infinity;
        return -factor * (known.count == 1 ? first_insertion : further_insertion);
    }

    void add_exits(const SideUse& in, int side, int change, const Turn& turn, int except,
                   std::vector<Step>& steps) const {
        const double cost = turn.block >= 0 ? cost_of(turn) : 0.0;
        if (cost == infinity) return;
        for (const ArcUse& use : layout_.blocks[at(in.block)].sides[at(side)]) {
            if (use.arc == except) continue;
            const double own = cost_of(use.arc, change);
            if (own == infinity) continue;
            const auto& uses = uses_[at(use.arc)];
            Step step{hub(), cost + own, turn, use.arc, change};
            if (uses.size() == 2) {
                const int here = uses[0].block == in.block && uses[0].side == side ? 0 : 1;
                step.to = state(use.arc, 1 - here, change);
            }
            steps.push_back(step);
        }
    }

    /// Found once, until one of their costs changes.
    const std::vector<Step>& steps_from(int from) {
        if (steps_[at(from)].empty()) find_steps(from, steps_[at(from)]);
        return steps_[at(from)];
    }

    void find_steps(int from, std::vector<Step>& steps) const {
        if (from == hub()) {
            for (std::size_t a = 0; a < uses_.size(); ++a) {
                if (uses_[a].size() != 1) continue;
                for (const int change : {-1, 1}) {
                    const double own = cost_of(int(a), change);
                    if (own < infinity)
                        steps.push_back({state(int(a), 0, change), own, {}, int(a), change});
                }
            }
            return;
        }
        const int arc = from / 4, change = from % 2 == 1 ? 1 : -1;
        const std::size_t use = std::size_t(from / 2 % 2);
        if (use >= uses_[at(arc)].size()) return;
        const SideUse& in = uses_[at(arc)][use];
        add_exits(in, in.side, -change, {}, arc, steps);
        add_exits(in, (in.side + 2) % 4, change, {}, -1, steps);
        const int pair = in.side % 2, sign = in.side < 2 ? change : -change;
        for (int corner = 0; corner < 4; ++corner) {
            const auto& signs = corner_signs[at(corner)];
            const Turn turn{in.block, corner, sign * signs[at(pair)]};
            const int other = signs[at(1 - pair)] * turn.change;
            add_exits(in, 1 - pair, other, turn, -1, steps);
            add_exits(in, 3 - pair, -other, turn, -1, steps);
        }
    }

    /// Their costs are those of the block's arcs and of its insertion.
    void forget_steps_into(int block) {
        for (const BlockSide& side : layout_.blocks[at(block)].sides)
            for (const ArcUse& use : side)
                for (std::size_t k = 0; k < uses_[at(use.arc)].size(); ++k)
                    if (uses_[at(use.arc)][k].block == block)
                        for (const int change : {-1, 1})
                            steps_[at(state(use.arc, int(k), change))].clear();
    }

    bool improve() {
        const std::size_t count = at(hub() + 1);
        std::vector<double> cost(count, 0.0);
        std::vector<int> from(count, -1);
        std::vector<Step> into(count);
        std::vector<char> active(count, 1);
        for (int pass = 1;; ++pass) {
            poll_();
            bool changed = false;
            for (std::size_t s = 0; s < count; ++s) {
                if (active[s] == 0 || banned_[s] != 0) continue;
                active[s] = 0;
                for (const Step& step : steps_from(int(s))) {
                    const double reached = cost[s] + step.cost;
                    if (!(reached < cost[at(step.to)] - worth_a_change) ||
                        banned_[at(step.to)] != 0)
                        continue;
                    cost[at(step.to)] = reached;
                    from[at(step.to)] = int(s);
                    into[at(step.to)] = step;
                    active[at(step.to)] = 1;
                    changed = true;
                }
            }
            if (!changed) return false;
            if (pass % passes_between == 0 && take_cycles(into, from)) return true;
        }
    }

    /// Takes what cycles there are; true if there was one, whether or not it gained.
    bool take_cycles(const std::vector<Step>& into, const std::vector<int>& from) {
        std::vector<int> seen(from.size(), -1);
        bool found = false;
        for (std::size_t start = 0; start < from.size(); ++start) {
            int s = int(start);
            while (s >= 0 && seen[at(s)] < 0) {
                seen[at(s)] = int(start);
                s = from[at(s)];
            }
            if (s < 0 || seen[at(s)] != int(start)) continue;
            std::vector<Step> cycle;
            int t = s;
            do {
                cycle.push_back(into[at(t)]);
                t = from[at(t)];
            } while (t != s);
            found = true;
            if (take(cycle))
                std::fill(banned_.begin(), banned_.end(), char(0));
            else
                banned_[at(s)] = 1;
        }
        return found;
    }

    /// Costs are those of the numbers as they were: an arc or a block that a way meets twice may
    /// cost more.
    bool take(const std::vector<Step>& steps) {
        const Divisions before = current_;
        const double cost = cost_of_divisions(layout_, current_);
        bool valid = true;
        for (const Step& step : steps) {
            current_.edges[at(step.arc)] += step.change;
            if (step.turn.block < 0) continue;
            Valence3Insertion& known = current_.insertions[at(step.turn.block)];
            if (known.count == 0) known.side = step.turn.corner;
            valid = valid && known.side == step.turn.corner;
            known.count += step.turn.change;
            valid = valid && known.count >= 0;
        }
        for (const Step& step : steps)
            valid = valid && current_.edges[at(step.arc)] >= layout_.arcs[at(step.arc)].least;
        if (!valid || !(cost_of_divisions(layout_, current_) < cost - worth_a_change)) {
            current_ = before;
            return false;
        }
        for (const Step& step : steps)
            for (const SideUse& use : uses_[at(step.arc)]) forget_steps_into(use.block);
        steps_[at(hub())].clear();
        return true;
    }

    const QuadLayout& layout_;
    Divisions current_;
    Poll& poll_;
    std::vector<std::vector<SideUse>> uses_;  ///< one a arc: one or two
    std::vector<std::vector<Step>> steps_;    ///< by state; see steps_from()
    std::vector<double> slenderness_;         ///< of blocks
    std::vector<char> banned_;                ///< states that led to no gain
};

}  // namespace

double cost_of_divisions(const QuadLayout& layout, const Divisions& divisions) {
    double sum = 0.0;
    for (std::size_t a = 0; a < layout.arcs.size(); ++a)
        sum += penalty(layout.arcs[a], divisions.edges[a]);
    for (std::size_t b = 0; b < layout.blocks.size(); ++b)
        if (const int count = divisions.insertions[b].count; count > 0)
            sum += slenderness(layout, layout.blocks[b]) *
                   (first_insertion + further_insertion * (count - 1));
    return sum;
}

Divisions improved_divisions(const QuadLayout& layout, const Divisions& valid, Poll& poll) {
    return DivisionSearch(layout, valid, poll).run();
}

}  // namespace patchwright::cage
