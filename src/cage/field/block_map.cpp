#include "cage/field/block_map.h"

#include "cage/field/block_frames.h"
#include "cage/field/linear_value.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Of the edges of an arc's points, against the blocks' energy: settles arcs that no block is
// beside.
constexpr double arc_weight = 1e-3;
// Arcs on end of which one after the other a point of a line is looked for.
constexpr int most_arcs = 100;
// Steps of a walk over triangles to a point.
constexpr int most_steps = 400;

}  // namespace

class BlockMap::Solver {
  public:
    Solver(const QuadLayout& layout, const Divisions& divisions, const SizeMetric& metric,
           Poll& poll)
        : layout_(layout),
          divisions_(divisions),
          metric_(metric),
          poll_(poll),
          frames_(layout, divisions) {
        number_unknowns();
        solve();
    }

    [[nodiscard]] FlatPiece::SurfacePoint locate(int block, Vec2 p) const {
        // The nearest triangle of the block, and from there across arcs.
        Triangle here{block, 0};
        double best = -base::infinity;
        const auto& triangles = piece(block).triangles();
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const auto w = weights({block, int(t)}, p);
            const double least = *std::min_element(w.begin(), w.end());
            if (least > best) {
                best = least;
                here.number = int(t);
            }
            if (best >= 0.0) break;
        }
        if (best >= 0.0) return point_in(here, p);
        for (int step = 0; step < most_steps; ++step) {
            const auto w = weights(here, p);
            const auto out = std::min_element(w.begin(), w.end());
            if (*out >= -1e-12) break;
            const int side = (int(out - w.begin()) + 1) % 3;  // opposite to that corner
            if (!cross_side(here, p, side)) break;
        }
        return point_in(here, p);
    }

    [[nodiscard]] std::vector<Vec3> along(int a) const {
        const int n = divisions_.edges[at(a)];
        std::vector<Vec3> result;
        for (int k = 0; k <= n; ++k)
            result.push_back(frames_.rigid(a) ? on_line(a, double(k)) : on_surface(a, double(k)));
        return result;
    }

  private:
    struct Triangle {
        int block, number;
    };
    [[nodiscard]] const FlatPiece& piece(int b) const {
        return layout_.pieces[at(layout_.blocks[at(b)].piece)];
    }
    [[nodiscard]] int edges(int a) const { return divisions_.edges[at(a)]; }
    [[nodiscard]] int last_point(int a) const { return int(layout_.arcs[at(a)].points.size()) - 1; }

    void number_unknowns() {
        for (std::size_t v = 0; v < layout_.nodes.size(); ++v) {
            first_of_node_.push_back(unknowns_);
            unknowns_ += frames_.freedom(int(v)).free;
        }
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a) {
            first_of_arc_.push_back(unknowns_);
            if (held(int(a))) continue;
            unknowns_ += (last_point(int(a)) - 1) * (frames_.rigid(int(a)) ? 1 : 2);
        }
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
            first_of_block_.push_back(unknowns_);
            unknowns_ += 2 * (int(piece(int(b)).points().size()) - border_count(int(b)));
        }
    }

    [[nodiscard]] int border_count(int b) const {
        int count = 0;
        for (const BlockSide& side : layout_.blocks[at(b)].sides)
            for (const ArcUse& use : side) count += last_point(use.arc);
        return count;
    }

    /// Whether the points of a line between nodes that stay are where its own sizes put them.
    [[nodiscard]] bool held(int a) const {
        const LayoutArc& arc = layout_.arcs[at(a)];
        return frames_.rigid(a) && arc.shares.size() == arc.points.size() &&
               frames_.freedom(arc.start).free == 0 && frames_.freedom(arc.end).free == 0;
    }

    /// How far a node has moved, in the frame of an arc that ends or starts there.
    [[nodiscard]] LinearPoint shift(int node, const ArcEnd& end) const {
        const NodeFreedom& f = frames_.freedom(node);
        if (f.free == 0) return {};
        const int first = first_of_node_[at(node)];
        LinearPoint v{LinearValue{0.0, 1.0, first}, LinearValue{}};
        if (f.free == 2) v[1] = {0.0, 1.0, first + 1};
        return turned(v, f.turn.at(end));
    }

    /// Coordinates of an arc's point k in its frame: along it, and to the left.
    [[nodiscard]] LinearPoint on_arc(int a, int k) const {
        const LayoutArc& arc = layout_.arcs[at(a)];
        if (k == 0) return shift(arc.start, {a, 0});
        if (k == last_point(a)) return shift(arc.end, {a, 1}) + Vec2(edges(a), 0.0);
        if (held(a)) return LinearPoint{LinearValue{edges(a) * arc.shares[at(k)]}, LinearValue{}};
        const int first = first_of_arc_[at(a)] + (k - 1) * (frames_.rigid(a) ? 1 : 2);
        LinearPoint v{LinearValue{0.0, 1.0, first}, LinearValue{}};
        if (!frames_.rigid(a)) v[1] = {0.0, 1.0, first + 1};
        return v;
    }

    /// Of all points of a block's piece.
    [[nodiscard]] std::vector<LinearPoint> values(int b) const {
        const LayoutBlock& block = layout_.blocks[at(b)];
        const int n = border_count(b), count = int(piece(b).points().size());
        std::vector<LinearPoint> result(at(count));
        int place = *block.first_point;
        for (int s = 0; s < 4; ++s) {
            int before = 0;
            for (std::size_t i = 0; i < block.sides[at(s)].size(); ++i) {
                const ArcUse& use = block.sides[at(s)][i];
                const ArcPlace u{b, s, int(i), before, use.reversed};
                const int last = last_point(use.arc);
                for (int k = 0; k < last; ++k)
                    result[at(place++ % n)] = turned(on_arc(use.arc, use.reversed ? last - k : k),
                                                     BlockFrames::quarters(u)) +
                                              frames_.origin(use.arc, u);
                before += edges(use.arc);
            }
        }
        for (int i = n; i < count; ++i)
            for (int c = 0; c < 2; ++c)
                result[at(i)][at(c)] = {0.0, 1.0, first_of_block_[at(b)] + 2 * (i - n) + c};
        return result;
    }

    void add_term(double weight, const LinearValue& a, const LinearValue& b) {
        const double constant = a.constant - b.constant;
        std::array<std::pair<int, double>, 2> parts{std::pair{a.unknown, a.factor},
                                                    std::pair{b.unknown, -b.factor}};
        for (const auto& [i, f] : parts) {
            if (i < 0) continue;
            right_[i] -= weight * f * constant;
            for (const auto& [j, g] : parts)
                if (j >= 0) entries_.emplace_back(i, j, weight * f * g);
        }
    }

    void solve() {
        if (unknowns_ == 0) {
            solution_.resize(0);
        } else {
            right_ = Eigen::VectorXd::Zero(unknowns_);
            for (std::size_t a = 0; a < layout_.arcs.size(); ++a) add_arc(int(a));
            for (std::size_t b = 0; b < layout_.blocks.size(); ++b) add_block(int(b));
            poll_();
            Eigen::SparseMatrix<double> matrix(unknowns_, unknowns_);
            matrix.setFromTriplets(entries_.begin(), entries_.end());
            const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(matrix);
            solution_ = factors.solve(right_);
            if (factors.info() != Eigen::Success || !solution_.allFinite())
                throw LayoutRefused{"blocks have no coordinates"};
            poll_();
        }
        flat_.resize(layout_.blocks.size());
        for (std::size_t b = 0; b < flat_.size(); ++b) {
            for (const LinearPoint& v : values(int(b))) flat_[b].emplace_back(of(v[0]), of(v[1]));
            join_triangles(int(b));
        }
    }

    void add_arc(int a) {
        const LayoutArc& arc = layout_.arcs[at(a)];
        double length = 0.0;
        for (int k = 0; k < last_point(a); ++k)
            length += (arc.points[at(k + 1)] - arc.points[at(k)]).norm();
        for (int k = 0; k < last_point(a); ++k) {
            const double step = (arc.points[at(k + 1)] - arc.points[at(k)]).norm();
            const LinearPoint p = on_arc(a, k), q = on_arc(a, k + 1);
            for (std::size_t c = 0; c < 2; ++c)
                add_term(arc_weight * length / std::max(step, 1e-9 * length), p[c], q[c]);
        }
    }

    void add_block(int b) {
        const auto value = values(b);
        for (const auto& [pair, weight] :
             metric_.side_weights(piece(b), layout_.blocks[at(b)].piece))
            for (std::size_t c = 0; c < 2; ++c)
                add_term(weight, value[at(pair.first)][c], value[at(pair.second)][c]);
    }

    [[nodiscard]] double of(const LinearValue& v) const {
        return v.constant + (v.unknown < 0 ? 0.0 : v.factor * solution_[v.unknown]);
    }

    // Walks.

    void join_triangles(int b) {
        auto& beyond = across_[b];
        const auto& triangles = piece(b).triangles();
        std::map<std::pair<int, int>, int> side_of;
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                side_of[{triangles[t][k], triangles[t][(k + 1) % 3]}] = int(t);
        beyond.assign(triangles.size(), {-1, -1, -1});
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto other = side_of.find({triangles[t][(k + 1) % 3], triangles[t][k]});
                if (other != side_of.end()) beyond[t][k] = other->second;
            }
        // Sides on arcs.
        const LayoutBlock& block = layout_.blocks[at(b)];
        const int n = border_count(b);
        int place = *block.first_point;
        for (int s = 0; s < 4; ++s) {
            for (std::size_t i = 0; i < block.sides[at(s)].size(); ++i) {
                const ArcUse& use = block.sides[at(s)][i];
                const int last = last_point(use.arc);
                for (int k = 0; k < last; ++k, ++place) {
                    const auto found = side_of.find({place % n, (place + 1) % n});
                    if (found == side_of.end()) continue;
                    const int on_arc = use.reversed ? last - 1 - k : k;
                    beside_[{use.arc, on_arc}].push_back({b, found->second, s, int(i)});
                    for (std::size_t j = 0; j < 3; ++j)
                        if (triangles[at(found->second)][j] == place % n)
                            border_sides_[{b, found->second, int(j)}] = {use.arc, on_arc};
                }
            }
        }
    }

    [[nodiscard]] ArcPlace use_at(int b, int s, int i) const {
        const int a = layout_.blocks[at(b)].sides[at(s)][at(i)].arc;
        for (const ArcPlace& u : frames_.places(a))
            if (u.block == b && u.side == s && u.place == i) return u;
        return frames_.places(a)[0];
    }

    /// Goes on beyond a side of a triangle; false where there is nothing.
    bool cross_side(Triangle& here, Vec2& p, int side) const {
        const int next = across_.at(here.block)[at(here.number)][at(side)];
        if (next >= 0) {
            here.number = next;
            return true;
        }
        const auto border = border_sides_.find({here.block, here.number, side});
        if (border == border_sides_.end() || frames_.rigid(border->second.first)) return false;
        const auto& both = beside_.at(border->second);
        if (both.size() != 2) return false;
        const int a = border->second.first;
        const bool first = both[0].block == here.block && both[0].triangle == here.number;
        const Beside &from = both[first ? 0 : 1], &to = both[first ? 1 : 0];
        const ArcPlace u = use_at(from.block, from.side, from.place),
                       w = use_at(to.block, to.side, to.place);
        p = turned(Vec2(p - frames_.origin(a, u)),
                   BlockFrames::quarters(w) - BlockFrames::quarters(u)) +
            frames_.origin(a, w);
        here = {to.block, to.triangle};
        return true;
    }

    [[nodiscard]] std::array<double, 3> weights(const Triangle& t, const Vec2& p) const {
        const auto& c = piece(t.block).triangles()[at(t.number)];
        const auto& flat = flat_[at(t.block)];
        const Vec2 &a = flat[at(c[0])], &b = flat[at(c[1])], &d = flat[at(c[2])];
        const double area = cross(b - a, d - a);
        if (!(area > 0.0)) return {-base::infinity, -base::infinity, -base::infinity};
        return {cross(b - p, d - p) / area, cross(d - p, a - p) / area, cross(a - p, b - p) / area};
    }

    [[nodiscard]] FlatPiece::SurfacePoint point_in(const Triangle& t, const Vec2& p) const {
        auto w = weights(t, p);
        double sum = 0.0;
        for (double& x : w) sum += x = std::clamp(std::isfinite(x) ? x : 1.0, 0.0, 1.0);
        // A triangle whose area is rounding: all of it is at p.
        if (sum == 0.0) {
            w = {1.0, 0.0, 0.0};
            sum = 1.0;
        }
        const auto& c = piece(t.block).triangles()[at(t.number)];
        const auto& points = piece(t.block).points();
        const Vec3 &a = points[at(c[0])], &b = points[at(c[1])], &d = points[at(c[2])];
        return {(w[0] * a + w[1] * b + w[2] * d) / sum, (b - a).cross(d - a).normalized(),
                t.number};
    }

    [[nodiscard]] Vec3 on_surface(int a, double k) const {
        const ArcPlace& u = frames_.places(a)[0];
        return locate(u.block,
                      frames_.origin(a, u) + turned(Vec2(k, 0.0), BlockFrames::quarters(u)))
            .point;
    }

    /// On an arc that is a line of the coordinates, or on those that continue it.
    [[nodiscard]] Vec3 on_line(int a, double k) const {
        bool backwards = false;  // k counts along the arc, or against it
        for (int step = 0; step < most_arcs; ++step) {
            const LayoutArc& arc = layout_.arcs[at(a)];
            const double want = backwards ? edges(a) - k : k;
            const int last = last_point(a);
            const double begin = of(on_arc(a, 0)[0]), end = of(on_arc(a, last)[0]);
            if (want >= begin && want <= end) {
                for (int i = 0; i < last; ++i) {
                    const double from = of(on_arc(a, i)[0]), to = of(on_arc(a, i + 1)[0]);
                    if (want > to && i + 1 < last) continue;
                    const double t =
                        to > from ? std::clamp((want - from) / (to - from), 0.0, 1.0) : 0.0;
                    return arc.points[at(i)] + t * (arc.points[at(i + 1)] - arc.points[at(i)]);
                }
            }
            // On to the arc that continues this one.
            const bool over = want > end;
            const int node = over ? arc.end : arc.start;
            const NodeFreedom& f = frames_.freedom(node);
            int next = -1, next_end = 0;
            if (f.free == 1)
                for (const auto& [other, turn] : f.turn)
                    if (frames_.rigid(other.first) && other != std::pair(a, over ? 1 : 0)) {
                        next = other.first;
                        next_end = other.second;
                    }
            if (next < 0) return over ? arc.points.back() : arc.points.front();
            k = over ? want - edges(a) : -want;
            a = next;
            backwards = next_end == 1;
        }
        return layout_.arcs[at(a)].points.front();
    }

    struct Beside {
        int block, triangle, side, place;
    };

    const QuadLayout& layout_;
    const Divisions& divisions_;
    const SizeMetric& metric_;
    Poll& poll_;
    BlockFrames frames_;
    int unknowns_ = 0;
    std::vector<int> first_of_node_;
    std::vector<int> first_of_arc_, first_of_block_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::VectorXd right_, solution_;
    std::vector<std::vector<Vec2>> flat_;
    std::map<int, std::vector<std::array<int, 3>>> across_;
    std::map<std::pair<int, int>, std::vector<Beside>> beside_;
    std::map<std::array<int, 3>, std::pair<int, int>> border_sides_;
};

BlockMap::BlockMap(const QuadLayout& layout, const Divisions& divisions, const SizeMetric& metric,
                   Poll& poll)
    : solver_(std::make_unique<Solver>(layout, divisions, metric, poll)) {}
BlockMap::~BlockMap() = default;
BlockMap::BlockMap(BlockMap&&) noexcept = default;
BlockMap& BlockMap::operator=(BlockMap&&) noexcept = default;

FlatPiece::SurfacePoint BlockMap::point(int block, const Vec2& p) const {
    return solver_->locate(block, p);
}
std::vector<Vec3> BlockMap::along(int arc) const { return solver_->along(arc); }

}  // namespace patchwright::cage
