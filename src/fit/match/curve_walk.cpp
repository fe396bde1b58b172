#include "fit/match/curve_walk.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <unordered_map>

namespace patchwright::fit {

using base::infinity;
using geom::Vec3;

namespace {

// A curve has not more steps, however short the chain is.
constexpr int max_steps = 4096;
// States between two polls: a millisecond or so.
constexpr std::size_t states_a_poll = 4096;
// A closed walk may begin on curves this much farther from the chain's first point than the nearest
// one, as on both sides of a fillet that the chain runs along.
constexpr double start_ratio = 3.0;
// The greatest penalty of a kind, times two: for the chain's points and for the steps.
constexpr double max_cost_rel = 6.0;

double distance_to_edge(const Vec3& a, const Vec3& b, const Vec3& q) {
    return (geom::nearest_on_segment(q, a, b).point - q).norm();
}

}  // namespace

CurveWalk::CurveWalk(const geom::ReferenceSurface& reference, const geom::CurveEnds& curve_ends,
                     const WalkOptions& options, const Polyline& line)
    : reference_(reference),
      features_(reference.features()),
      curve_ends_(curve_ends),
      options_(options),
      line_(line),
      share_(line.size(), 0.0) {
    for (std::size_t i = 1; i < line.size(); ++i) {
        const double half = 0.5 * (line[i] - line[i - 1]).norm();
        share_[i - 1] += half;
        share_[i] += half;
    }
}

double CurveWalk::penalty(int curve) const {
    return kind_mismatch_penalty(options_.kind, features_.curves[std::size_t(curve)].kind);
}

void CurveWalk::add_stop(const Stop& stop, int junction) {
    if (stop.corner >= 0) return;
    for (int c = 0; c < int(features_.curves.size()); ++c) {
        if (std::isinf(penalty(c))) continue;
        const auto here = reference_.nearest_on_curve(c, stop.point);
        if (here.distance > options_.coincidence_mm) continue;
        divisions_.push_back({c, here.arc_length, junction});
    }
}

void CurveWalk::number_steps() {
    const double step = geom::length_of(line_) / double(line_.size() - 1);
    std::vector<int> counts;
    for (std::size_t c = 0; c < features_.curves.size(); ++c) {
        const double wanted = std::ceil(features_.curves[c].length / step);
        counts.push_back(
            std::isinf(penalty(int(c))) ? 0 : int(std::clamp(wanted, 2.0, double(max_steps))));
    }
    for (const Division& division : divisions_) ++counts[std::size_t(division.curve)];
    first_.assign(1, 0);
    for (const int count : counts) first_.push_back(first_.back() + count);
    slot_.assign(counts.size(), -1);
    steps_.clear();
}

int CurveWalk::count(int curve) const {
    return first_[std::size_t(curve) + 1] - first_[std::size_t(curve)];
}

CurveWalk::Steps& CurveWalk::steps(int curve) {
    int& slot = slot_[std::size_t(curve)];
    if (slot >= 0) return steps_[std::size_t(slot)];
    slot = int(steps_.size());
    Steps& steps = steps_.emplace_back();
    const double length = features_.curves[std::size_t(curve)].length;
    const auto divided = std::count_if(divisions_.begin(), divisions_.end(),
                                       [&](const Division& d) { return d.curve == curve; });
    const int even = count(curve) - int(divided);
    for (int k = 0; k < even; ++k) steps.arc.push_back(length * k / even);
    steps.arc.push_back(length);  // exactly, lest a stop there lies beyond it
    steps.junction.assign(steps.arc.size(), -1);
    const auto [start, end] = curve_ends_.places[std::size_t(curve)];
    if (start >= 0) steps.junction.front() = start + 2;
    if (end >= 0) steps.junction.back() = end + 2;
    for (const Division& division : divisions_) {
        if (division.curve != curve) continue;
        const auto at = std::lower_bound(steps.arc.begin(), steps.arc.end(), division.arc);
        const auto k = std::clamp<std::ptrdiff_t>(at - steps.arc.begin(), 1,
                                                  std::ptrdiff_t(steps.arc.size()) - 1);
        steps.arc.insert(steps.arc.begin() + k, division.arc);
        steps.junction.insert(steps.junction.begin() + k, division.junction);
    }
    steps.point.assign(steps.arc.size(), std::nullopt);
    return steps;
}

std::vector<int> CurveWalk::leaving(int junction) {
    std::vector<int> moves;
    for (const Division& division : divisions_) {
        if (division.junction != junction) continue;
        const std::vector<int>& of_points = steps(division.curve).junction;
        const auto k =
            int(std::find(of_points.begin(), of_points.end(), junction) - of_points.begin());
        moves.push_back(number({division.curve, k, false}));
        moves.push_back(number({division.curve, k - 1, true}));
    }
    if (junction < 2) return moves;
    for (const auto& [curve, at_end] : curve_ends_.curves[std::size_t(junction) - 2])
        if (count(curve) > 0)
            moves.push_back(number({curve, at_end ? count(curve) - 1 : 0, at_end}));
    return moves;
}

CurveWalk::Move CurveWalk::move(int number) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), number / 2);
    const auto curve = int(after - first_.begin()) - 1;
    return {curve, number / 2 - first_[std::size_t(curve)], number % 2 != 0};
}

int CurveWalk::number(const Move& m) const {
    return 2 * (first_[std::size_t(m.curve)] + m.step) + (m.reversed ? 1 : 0);
}

double CurveWalk::length_of(const Move& m) {
    const Steps& steps = this->steps(m.curve);
    return steps.arc[std::size_t(m.step) + 1] - steps.arc[std::size_t(m.step)];
}

const Vec3& CurveWalk::point(int curve, int k) {
    Steps& steps = this->steps(curve);
    std::optional<Vec3>& p = steps.point[std::size_t(k)];
    if (!p) p = reference_.point_on_curve(curve, steps.arc[std::size_t(k)]).point;
    return *p;
}

std::vector<int> CurveWalk::moves_after(int number) {
    const Move m = move(number);
    const Steps& steps = this->steps(m.curve);
    const int end = end_of(m), last = int(steps.arc.size()) - 1;
    const int junction = steps.junction[std::size_t(end)];
    if (junction < 0) {
        const int next = m.reversed ? (m.step + last - 1) % last : (m.step + 1) % last;
        return {this->number({m.curve, next, m.reversed})};
    }
    std::vector<int> moves;
    for (const int next : leaving(junction))
        if (next != (number ^ 1)) moves.push_back(next);
    return moves;
}

double CurveWalk::distance_to_move(int number, const Vec3& q) {
    const Move m = move(number);
    const Vec3 start = point(m.curve, m.step);
    return distance_to_edge(start, point(m.curve, m.step + 1), q);
}

double CurveWalk::point_cost(std::size_t i, int number) {
    return penalty(move(number).curve) * share_[i] * distance_to_move(number, line_[i]);
}

double CurveWalk::step_cost(std::size_t i, int from, int to) {
    const Move a = move(from), b = move(to);
    const Vec3& joint = point(a.curve, end_of(a));
    const double distance =
        distance_to_edge(line_[i], line_[std::min(i + 1, line_.size() - 1)], joint);
    const auto half = [&](const Move& m) { return 0.5 * penalty(m.curve) * length_of(m); };
    return (half(a) + half(b)) * (distance + options_.length_cost_mm);
}

CurveWalk::Walk CurveWalk::cheapest(const std::vector<int>& first, const std::vector<int>& last,
                                    double limit) {
    struct Visit {
        double cost = infinity;
        std::int64_t before = -1;
    };
    // A state is a point of the chain and the move beside it.
    const std::int64_t moves = 2 * std::int64_t(first_.back());
    std::unordered_map<std::int64_t, Visit> visits;
    using Entry = std::pair<double, std::int64_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    const auto reach = [&](std::int64_t state, double cost, std::int64_t before) {
        if (!(cost < limit)) return;
        Visit& visit = visits[state];
        if (cost >= visit.cost) return;
        visit = {cost, before};
        open.emplace(cost, state);
    };
    for (const int m : first) reach(m, point_cost(0, m), -1);
    Walk walk;
    const std::size_t goal = line_.size() - 1;
    std::int64_t state = -1;
    for (std::size_t visited = 0; !open.empty(); ++visited) {
        if (visited % states_a_poll == 0) options_.poll();
        double cost = 0.0;
        std::tie(cost, state) = open.top();
        open.pop();
        if (cost > visits[state].cost) continue;
        const auto i = std::size_t(state / moves);
        const int m = int(state % moves);
        if (i == goal && std::find(last.begin(), last.end(), m) != last.end()) {
            walk.cost = cost;
            break;
        }
        if (i < goal) reach(state + moves, cost + point_cost(i + 1, m), state);
        for (const int next : moves_after(m))
            reach(state - m + next, cost + step_cost(i, m, next), state);
    }
    if (std::isinf(walk.cost)) return walk;
    for (; state >= 0; state = visits[state].before) {
        const auto i = std::size_t(state / moves);
        const int m = int(state % moves);
        if (walk.moves.empty() || walk.moves.back() != m) walk.moves.push_back(m);
        const std::int64_t before = visits[state].before;
        if (before < 0 || std::size_t(before / moves) != i)
            walk.mean_distance += distance_to_move(m, line_[i]) / double(line_.size());
    }
    std::reverse(walk.moves.begin(), walk.moves.end());
    return walk;
}

std::vector<int> CurveWalk::first_moves() {
    const Vec3& q = line_.front();
    const int curves = int(features_.curves.size());
    std::vector<double> far(features_.curves.size(), infinity);
    double nearest = infinity;
    for (int c = 0; c < curves; ++c) {
        if (count(c) == 0) continue;
        double& distance = far[std::size_t(c)];
        distance = penalty(c) * reference_.nearest_on_curve(c, q).distance;
        nearest = std::min(nearest, distance);
    }
    const double most = start_ratio * (nearest + options_.length_cost_mm);
    std::vector<int> moves;
    for (int c = 0; c < curves; ++c) {
        if (!(far[std::size_t(c)] <= most)) continue;
        const int steps = count(c);
        std::vector<double> distance;
        for (int k = 0; k < steps; ++k)
            distance.push_back(penalty(c) * distance_to_move(number({c, k, false}), q));
        for (int k = 0; k < steps; ++k) {
            const double d = distance[std::size_t(k)];
            const double before = distance[std::size_t((k + steps - 1) % steps)];
            const double after = distance[std::size_t((k + 1) % steps)];
            if (d > before || d > after || d > most + options_.length_cost_mm) continue;
            moves.push_back(number({c, k, false}));
            moves.push_back(number({c, k, true}));
        }
    }
    return moves;
}

FeaturePath CurveWalk::between(const std::array<Stop, 2>& stops) {
    std::array<int, 2> junctions{0, 1};
    for (std::size_t k = 0; k < 2; ++k) {
        if (stops[k].corner >= 0) junctions[k] = stops[k].corner + 2;
        add_stop(stops[k], int(k));
    }
    number_steps();
    std::vector<int> last;
    for (const int m : leaving(junctions[1])) last.push_back(m ^ 1);
    const double limit = max_cost_rel * options_.reach_mm * geom::length_of(line_);
    const Walk walk = cheapest(leaving(junctions[0]), last, limit);
    mean_distance_ = walk.mean_distance;
    return path_of(walk.moves);
}

FeaturePath CurveWalk::round() {
    number_steps();
    Walk best;
    double limit = max_cost_rel * options_.reach_mm * geom::length_of(line_);
    for (const int first : first_moves()) {
        Walk walk = cheapest({first}, {first}, limit);
        if (walk.moves.size() < 3) continue;
        limit = walk.cost;
        best = std::move(walk);
    }
    if (best.moves.empty()) return {};
    best.moves.pop_back();  // the first one again
    mean_distance_ = best.mean_distance;
    return path_of(best.moves);
}

FeaturePath CurveWalk::path_of(const std::vector<int>& moves) {
    FeaturePath path;
    for (const int n : moves) {
        const Move m = move(n);
        const Steps& steps = this->steps(m.curve);
        const bool goes_on =
            !path.empty() && path.back().curve == m.curve && path.back().reversed == m.reversed;
        // Across the start of a closed curve that has no corner there, too.
        if (goes_on && m.reversed)
            path.back().range.from -= length_of(m);
        else if (goes_on)
            path.back().range.to += length_of(m);
        else
            path.push_back({m.curve,
                            {steps.arc[std::size_t(m.step)], steps.arc[std::size_t(m.step) + 1]},
                            m.reversed});
    }
    path.erase(std::remove_if(path.begin(), path.end(),
                              [](const FeaturePiece& p) { return !(p.range.to > p.range.from); }),
               path.end());
    return path;
}

}  // namespace patchwright::fit
