#include "measure/piece_meeting.h"
#include "measure/surface_crossing.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/self_intersection.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

namespace patchwright::measure {

using geom::Vec3;

// Two points of a surface differ by a sum of derivatives along any way between them. Along one of
// which both parameters run one way only, they differ by a d + b e with a, b >= 0, d a mean of the
// derivatives along u and e of those along v (or with the other sign of v). So a piece does not
// meet itself, nor do two pieces that touch in the parameter plane meet elsewhere, where the
// derivatives of all of them fit into one half-space for each sign. This needs no condition on the
// boundary, unlike a bound on normals (Volino, Magnenat-Thalmann, Efficient self-collision
// detection on smoothly discretized surface animations, 1994).

namespace {

bool is_simple(const DirectionCone& du, const DirectionCone& dv) {
    return share_half_space({du, dv}) && share_half_space({du, dv.opposite()});
}

/// How the sides of a surface hang together.
struct Domain {
    std::array<double, 2> u{}, v{};
    bool closed_u = false, closed_v = false;  ///< the first side and the last are one curve
    /// Sides that are a point: u low, u high, v low, v high.
    std::array<bool, 4> is_point{};

    Domain() = default;
    explicit Domain(const geom::BsplineSurface& s)
        : u{s.knots_u.front(), s.knots_u.back()}, v{s.knots_v.front(), s.knots_v.back()} {
        // Shared sides come from the same numbers; files keep 15 digits of them.
        constexpr double same_rel = 1e-9;
        const double same = same_rel * geom::bounding_box(s.points).diagonal();
        const Eigen::Index last_u = s.rows() - 1, last_v = s.columns() - 1;
        closed_u = closed_v = true;
        is_point.fill(true);
        for (Eigen::Index j = 0; j <= last_v; ++j) {
            closed_u = closed_u && (s.point(0, j) - s.point(last_u, j)).norm() <= same;
            is_point[0] = is_point[0] && (s.point(0, j) - s.point(0, 0)).norm() <= same;
            is_point[1] = is_point[1] && (s.point(last_u, j) - s.point(last_u, 0)).norm() <= same;
        }
        for (Eigen::Index i = 0; i <= last_u; ++i) {
            closed_v = closed_v && (s.point(i, 0) - s.point(i, last_v)).norm() <= same;
            is_point[2] = is_point[2] && (s.point(i, 0) - s.point(0, 0)).norm() <= same;
            is_point[3] = is_point[3] && (s.point(i, last_v) - s.point(0, last_v)).norm() <= same;
        }
    }

    [[nodiscard]] bool on_side(const Extent& e, std::size_t side) const {
        return side < 2 ? e.u[side] == u[side] : e.v[side - 2] == v[side - 2];
    }
    /// Whether the rectangles have a point in common, also across closed sides.
    [[nodiscard]] bool touch(const Extent& a, const Extent& b) const {
        const auto meet = [](const auto& r, const auto& q, const auto& whole, bool closed) {
            return (r[0] <= q[1] && q[0] <= r[1]) ||
                   (closed && ((r[0] == whole[0] && q[1] == whole[1]) ||
                               (q[0] == whole[0] && r[1] == whole[1])));
        };
        return meet(a.u, b.u, u, closed_u) && meet(a.v, b.v, v, closed_v);
    }
};

enum class Relation { Apart, Joined, Open };

/// A surface in pieces, with bounds for groups of its spans.
class SurfaceTree {
  public:
    SurfaceTree(const geom::BsplineSurface& surface, double resolution)
        : resolution_(resolution), domain_(surface) {
        constexpr double least_of_resolution = 1e-7, least_rel = 1e-12;
        least_ = std::max(least_of_resolution * resolution,
                          least_rel * geom::bounding_box(surface.points).diagonal());
        surface_ = &surface;
        grid_ = bezier_grid(surface, least_);
        nodes_.reserve(2 * grid_.pieces.size());
        build(0, grid_.spans_u, 0, grid_.spans_v);
    }

    /// Pairs of spans (equal ones: a span with itself) that the bounds of groups do not settle.
    [[nodiscard]] std::vector<std::array<int, 2>> candidates() const {
        std::vector<std::array<int, 2>> pairs;
        within(0, pairs);
        return pairs;
    }

    [[nodiscard]] const BezierGrid& grid() const { return grid_; }

    [[nodiscard]] std::optional<SelfIntersection> search(const std::array<int, 2>& pair) const {
        const BezierPiece& a = grid_.pieces[std::size_t(pair[0])];
        if (pair[0] == pair[1]) return search(a);
        return search(a, grid_.pieces[std::size_t(pair[1])]);
    }

  private:
    struct Node : Extent {
        int span = -1;  ///< of a leaf
        std::array<int, 2> child{-1, -1};
    };

    int build(std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1) {
        const int number = int(nodes_.size());
        nodes_.emplace_back();
        if (i1 - i0 == 1 && j1 - j0 == 1) {
            Node leaf{grid_.pieces[i0 * grid_.spans_v + j0]};
            leaf.span = int(i0 * grid_.spans_v + j0);
            nodes_[std::size_t(number)] = leaf;
            return number;
        }
        std::array<int, 2> child{};
        if (i1 - i0 >= j1 - j0) {
            const std::size_t half = (i0 + i1) / 2;
            child = {build(i0, half, j0, j1), build(half, i1, j0, j1)};
        } else {
            const std::size_t half = (j0 + j1) / 2;
            child = {build(i0, i1, j0, half), build(i0, i1, half, j1)};
        }
        const Node &a = nodes_[std::size_t(child[0])], &b = nodes_[std::size_t(child[1])];
        Node node;
        node.child = child;
        node.u = {a.u[0], b.u[1]};
        node.v = {a.v[0], b.v[1]};
        node.box = a.box;
        node.box.add(b.box);
        node.du = merge(a.du, b.du);
        node.dv = merge(a.dv, b.dv);
        nodes_[std::size_t(number)] = node;
        return number;
    }

    void within(int number, std::vector<std::array<int, 2>>& pairs) const {
        const Node& node = nodes_[std::size_t(number)];
        if (is_simple(node.du, node.dv)) return;
        if (node.span >= 0) {
            pairs.push_back({node.span, node.span});
            return;
        }
        within(node.child[0], pairs);
        within(node.child[1], pairs);
        between(node.child[0], node.child[1], pairs);
    }

    void between(int first, int second, std::vector<std::array<int, 2>>& pairs) const {
        const Node &a = nodes_[std::size_t(first)], &b = nodes_[std::size_t(second)];
        if (relation(a, b) == Relation::Apart) return;
        if (a.span >= 0 && b.span >= 0) {
            pairs.push_back({a.span, b.span});
        } else if (b.span >= 0 || (a.span < 0 && a.size() >= b.size())) {
            for (const int child : a.child) between(child, second, pairs);
        } else {
            for (const int child : b.child) between(first, child, pairs);
        }
    }

    /// Apart: they do not meet but where they touch in the parameter plane. Joined: they touch
    /// there, and may meet elsewhere. Open: they do not touch there, and may meet.
    [[nodiscard]] Relation relation(const Extent& a, const Extent& b) const {
        if ((a.box.min.array() > b.box.max.array()).any() ||
            (b.box.min.array() > a.box.max.array()).any())
            return Relation::Apart;
        if (domain_.touch(a, b)) {
            const bool simple = share_half_space({a.du, b.du, a.dv, b.dv}) &&
                                share_half_space({a.du, b.du, a.dv.opposite(), b.dv.opposite()});
            return simple ? Relation::Apart : Relation::Joined;
        }
        for (std::size_t side = 0; side < 4; ++side) {
            if (!domain_.is_point[side] || !domain_.on_side(a, side) || !domain_.on_side(b, side))
                continue;
            const auto& from = side < 2 ? a.du : a.dv;
            const auto& to = side < 2 ? b.du : b.dv;
            return share_half_space({from.opposite(), to}) ? Relation::Apart : Relation::Joined;
        }
        return Relation::Open;
    }

    [[nodiscard]] std::optional<SelfIntersection> search(const BezierPiece& piece) const {
        if (is_simple(piece.du, piece.dv) || piece.size() <= resolution_) return std::nullopt;
        const auto [low, high] = piece.halves(least_);
        if (auto hit = search(low)) return hit;
        if (auto hit = search(high)) return hit;
        return search(low, high);
    }

    [[nodiscard]] std::optional<SelfIntersection> search(const BezierPiece& a,
                                                         const BezierPiece& b) const {
        const bool small = a.size() <= resolution_ && b.size() <= resolution_;
        if (small && domain_.touch(a, b)) return std::nullopt;
        const Relation relation = this->relation(a, b);
        if (relation == Relation::Apart) return std::nullopt;
        if (relation == Relation::Open) {
            if (are_apart(a, b, 0.0)) return std::nullopt;
            if (auto hit = loop_at(a, b)) return hit;
        }
        if (small) return std::nullopt;
        const bool split_a = a.size() >= b.size();
        for (const BezierPiece& part : (split_a ? a : b).halves(least_)) {
            if (auto hit = split_a ? search(part, b) : search(a, part)) return hit;
        }
        return std::nullopt;
    }

    [[nodiscard]] std::optional<SelfIntersection> loop_at(const BezierPiece& a,
                                                          const BezierPiece& b) const {
        constexpr double exact = 1e-6;  // of the resolution
        const auto met = meeting_point(a, b, exact * resolution_);
        if (!met || !is_loop(*met)) return std::nullopt;
        return SelfIntersection{{}, met->point, met->uv};
    }

    /// Whether the surface leaves the place between the two visits, which are not merely at sides
    /// that are joined.
    [[nodiscard]] bool is_loop(const PieceMeeting& hit) const {
        const auto beside = [&](const Eigen::Vector2d& uv) {
            return is_beside_side(*surface_, hit.point, uv, resolution_);
        };
        return !stays_near(*surface_, hit.point, hit.uv[0], hit.uv[1], resolution_) &&
               !(beside(hit.uv[0]) && beside(hit.uv[1]));
    }

    double resolution_ = 0.0, least_ = 0.0;
    const geom::BsplineSurface* surface_ = nullptr;
    Domain domain_;
    BezierGrid grid_;
    std::vector<Node> nodes_;
};

}  // namespace

std::vector<SelfIntersection> find_self_intersections(
    const std::vector<geom::BsplineSurface>& surfaces, double resolution_mm,
    const base::Progress& progress) {
    if (!(resolution_mm > 0.0))
        throw base::InvalidArgument("find_self_intersections: the resolution must be positive");
    struct Task {
        std::size_t surface;
        std::array<int, 2> pair;
    };
    std::vector<std::unique_ptr<const SurfaceTree>> shapes(surfaces.size());
    std::vector<std::vector<std::array<int, 2>>> pairs(surfaces.size());
    base::parallel_for(surfaces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            shapes[k] = std::make_unique<const SurfaceTree>(surfaces[k], resolution_mm);
            pairs[k] = shapes[k]->candidates();
        }
    });
    std::vector<Task> tasks;
    for (std::size_t k = 0; k < surfaces.size(); ++k)
        for (const auto& pair : pairs[k]) tasks.push_back({k, pair});

    // The first hit in the order of the tasks, whichever thread is faster.
    constexpr auto none = std::numeric_limits<std::size_t>::max();
    std::vector<std::atomic<std::size_t>> first(surfaces.size());
    for (auto& f : first) f = none;
    std::vector<SelfIntersection> hits(surfaces.size());
    std::mutex mutex;
    constexpr std::size_t block = 512, grain = 4;
    for (std::size_t start = 0; start < tasks.size(); start += block) {
        base::report_progress(progress, "self-intersection", double(start) / double(tasks.size()));
        base::parallel_for(std::min(block, tasks.size() - start), grain,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t k = start + begin; k < start + end; ++k) {
                                   const std::size_t s = tasks[k].surface;
                                   if (k > first[s]) continue;
                                   const auto hit = shapes[s]->search(tasks[k].pair);
                                   if (!hit) continue;
                                   const std::lock_guard lock(mutex);
                                   if (k > first[s]) continue;
                                   first[s] = k;
                                   hits[s] = *hit;
                                   hits[s].surfaces = {int(s), int(s)};
                               }
                           });
    }
    std::vector<SelfIntersection> result;
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        if (first[s] != none) result.push_back(hits[s]);
    std::vector<const BezierGrid*> grids;
    for (const auto& shape : shapes) grids.push_back(&shape->grid());
    const auto crossings = find_crossings(surfaces, grids, resolution_mm, progress);
    result.insert(result.end(), crossings.begin(), crossings.end());
    return result;
}

}  // namespace patchwright::measure
