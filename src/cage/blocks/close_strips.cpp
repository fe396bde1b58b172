#include "cage/blocks/close_strips.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::EdgeSides;
using geom::Vec3;
using geom::VertexKind;

namespace {

// Of the width: opposite to a vertex one is made where none is as near as this, a quarter of the
// width from there at most; so it is farther from both than what is collapsed along features.
constexpr double least_step = 1.25, farthest_from_foot = 0.25;
// Of the width: length of sides across a strip that are collapsed, as that of the diagonal of both.
constexpr double longest_across = 1.75;
// Passes over a strip until it has no vertices to take out and no sides to shorten.
constexpr int most_passes = 40;

class StripCloser {
  public:
    StripCloser(geom::EditableMesh& mesh, const geom::ModelSurface& reference, double width_mm,
                Poll& poll)
        : mesh_(mesh), reference_(reference), width_(width_mm), poll_(poll) {}

    int run() {
        int closed = 0;
        for (int seed = 0; seed < mesh_.triangle_count(); ++seed) {
            region_of_.resize(at(mesh_.triangle_count()), -1);
            if (!mesh_.alive(seed) || region_of_[at(seed)] >= 0) continue;
            poll_();
            find_region(seed);
            if (!may_be_strip()) continue;
            const geom::EditableMesh before = mesh_;
            simplify();
            if (is_strip() && opens_out()) close();
            if (region_.empty()) {
                ++closed;
            } else {
                mesh_ = before;
                region_of_.resize(at(mesh_.triangle_count()));
            }
        }
        return closed;
    }

  private:
    /// All that is reached from a triangle without crossing a feature.
    void find_region(int seed) {
        ++number_;
        region_ = {seed};
        region_of_[at(seed)] = number_;
        for (std::size_t i = 0; i < region_.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                if (mesh_.curve(region_[i], k) >= 0) continue;
                const int next = beyond(region_[i], k);
                if (next < 0 || region_of_[at(next)] == number_) continue;
                region_of_[at(next)] = number_;
                region_.push_back(next);
            }
        }
    }

    [[nodiscard]] std::pair<int, int> ends(int t, int k) const {
        const auto& c = mesh_.triangle(t);
        return {c[at(k)], c[at((k + 1) % 3)]};
    }
    [[nodiscard]] double length(int a, int b) const {
        return (mesh_.point(a) - mesh_.point(b)).norm();
    }
    [[nodiscard]] int beyond(int t, int k) const {
        const auto [a, b] = ends(t, k);
        const EdgeSides s = mesh_.sides(a, b);
        return s.triangle[0] == t ? s.triangle[1] : s.triangle[0];
    }

    /// By area and border: whether it may be narrow on average.
    [[nodiscard]] bool may_be_strip() const {
        double area = 0.0, border = 0.0;
        for (const int t : region_) {
            area += 0.5 * mesh_.area_vector(t).norm();
            for (int k = 0; k < 3; ++k)
                if (mesh_.curve(t, k) >= 0) border += length(ends(t, k).first, ends(t, k).second);
        }
        return area < 0.5 * border * width_;
    }

    /// Takes out vertices inside, and those on features that are near to another one, one after the
    /// other.
    void simplify() {
        for (int pass = 0; pass < most_passes; ++pass) {
            bool any = false;
            for (std::size_t i = 0; i < region_.size(); ++i)
                for (int k = 0; k < 3 && mesh_.alive(region_[i]); ++k)
                    any = take_out(mesh_.triangle(region_[i])[at(k)]) || any;
            std::erase_if(region_, [&](int t) { return !mesh_.alive(t); });
            if (!(flip_all() || any)) return;
        }
    }

    /// Whether only one triangle of the region is at a vertex, as where a feature turns back.
    [[nodiscard]] bool is_tip(int v) const {
        const auto& fan = mesh_.fan(v);
        return 1 == std::count_if(fan.begin(), fan.end(),
                                  [&](int t) { return region_of_[at(t)] == number_; });
    }

    bool take_out(int v) {
        const bool inside = mesh_.kind(v) == VertexKind::Smooth;
        if (!inside && is_tip(v)) return false;
        int best = -1;
        double least = inside ? base::infinity : width_;
        for (const int w : mesh_.neighbours(v)) {
            if (length(v, w) >= least || !mesh_.can_collapse(v, w)) continue;
            least = length(v, w);
            best = w;
        }
        if (best < 0) return false;
        mesh_.collapse(v, best);
        return true;
    }

    /// To shorter sides, which cross the strip.
    bool flip_all() {
        bool any = false;
        for (const int t : region_)
            for (int k = 0; k < 3; ++k) {
                if (mesh_.curve(t, k) >= 0) continue;
                const auto [a, b] = ends(t, k);
                const int c = mesh_.triangle(t)[at((k + 2) % 3)], other = beyond(t, k);
                if (other < 0) continue;
                int d = -1;
                for (const int v : mesh_.triangle(other))
                    if (v != a && v != b) d = v;
                if (length(c, d) >= length(a, b) || !mesh_.can_flip(a, b)) continue;
                mesh_.flip(a, b);
                any = true;
            }
        return any;
    }

    /// Whether all vertices are on features, and no triangle is higher than the width.
    [[nodiscard]] bool is_strip() const {
        return std::all_of(region_.begin(), region_.end(), [&](int t) {
            double longest = 0.0;
            for (int k = 0; k < 3; ++k) {
                if (mesh_.kind(mesh_.triangle(t)[at(k)]) == VertexKind::Smooth) return false;
                longest = std::max(longest, length(ends(t, k).first, ends(t, k).second));
            }
            return mesh_.area_vector(t).norm() < width_ * longest;
        });
    }

    /// Whether what lies beside turns away from the strip, by the mean over its border: where sides
    /// are parallel, as beside the rim of a plate, a body as thin as the strip would be left flat.
    [[nodiscard]] bool opens_out() const {
        double sum = 0.0, border = 0.0;
        for (const int t : region_)
            for (int k = 0; k < 3; ++k) {
                if (mesh_.curve(t, k) < 0) continue;
                const double side = length(ends(t, k).first, ends(t, k).second);
                border += side;
                if (const int other = beyond(t, k); other >= 0)
                    sum += side * mesh_.area_vector(t).normalized().dot(
                                      mesh_.area_vector(other).normalized());
            }
        return sum > std::sin(0.5 * geom::least_bend_rad) * border;
    }

    void close() {
        do {
            while (collapse_shortest())
                std::erase_if(region_, [&](int t) { return !mesh_.alive(t); });
        } while (split_opposite());
    }

    /// Which of two vertices stays, least first: on the border of the surface; then by the longest
    /// feature along the strip there, and where on it.
    using Rank = std::tuple<int, double, int, double>;
    [[nodiscard]] Rank rank(int v) const {
        int longest = -1;
        double most = 0.0;
        for (const int t : mesh_.fan(v)) {
            if (region_of_[at(t)] != number_) continue;
            const int k = mesh_.corner_of(t, v);
            for (const int side : {k, (k + 2) % 3}) {
                const int curve = mesh_.curve(t, side);
                if (curve < 0) continue;
                const double length = reference_.features().curves[at(curve)].length;
                if (length > most) std::tie(longest, most) = std::pair(curve, length);
            }
        }
        const double along =
            longest < 0 ? 0.0 : reference_.nearest_on_curve(longest, mesh_.point(v)).arc_length;
        return {mesh_.is_boundary(v) ? 0 : 1, -most, longest, along};
    }

    bool collapse_shortest() {
        std::vector<std::tuple<double, int, int>> sides;
        for (const int t : region_)
            for (int k = 0; k < 3; ++k) {
                const auto [a, b] = ends(t, k);
                const double longest = mesh_.curve(t, k) < 0 ? longest_across : 1.0;
                if (length(a, b) < longest * width_) sides.emplace_back(length(a, b), a, b);
            }
        std::sort(sides.begin(), sides.end());
        for (const auto& [distance, a, b] : sides) {
            poll_();
            const bool a_stays = rank(a) < rank(b);
            const int gone = a_stays ? b : a, kept = a_stays ? a : b;
            if (!mesh_.stays_manifold(gone, kept)) continue;
            mesh_.collapse(gone, kept);
            return true;
        }
        return false;
    }

    /// Gives a feature a vertex opposite to one of the other.
    bool split_opposite() {
        for (const int t : region_)
            for (int k = 0; k < 3; ++k) {
                const int curve = mesh_.curve(t, k);
                if (curve < 0) continue;
                const auto [a, b] = ends(t, k);
                const Vec3 &p = mesh_.point(mesh_.triangle(t)[at((k + 2) % 3)]),
                           &from = mesh_.point(a), way = mesh_.point(b) - from;
                const double share = (p - from).dot(way) / way.squaredNorm();
                const Vec3 foot = from + share * way;
                if (std::min(share, 1.0 - share) * way.norm() < least_step * width_ ||
                    (p - foot).norm() >= width_)
                    continue;
                const Vec3 on_curve = reference_.nearest_on_curve(curve, foot).point;
                const bool is_near = (on_curve - foot).norm() < farthest_from_foot * width_;
                split(a, b, is_near ? on_curve : foot);
                return true;
            }
        return false;
    }

    void split(int a, int b, const Vec3& where) {
        const EdgeSides s = mesh_.sides(a, b);
        mesh_.split(a, b, where);
        for (const int t : s.triangle) {
            if (t < 0) continue;
            if (region_of_[at(t)] == number_) region_.push_back(int(region_of_.size()));
            region_of_.push_back(region_of_[at(t)]);
        }
    }

    geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    double width_;
    Poll& poll_;
    std::vector<int> region_;     ///< triangles
    std::vector<int> region_of_;  ///< one a triangle: number of the last region that it was in
    int number_ = -1;
};

}  // namespace

int close_strips(geom::EditableMesh& mesh, const geom::ModelSurface& reference, double width_mm,
                 Poll& poll) {
    return StripCloser(mesh, reference, width_mm, poll).run();
}

}  // namespace patchwright::cage
