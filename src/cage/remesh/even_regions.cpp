#include "cage/remesh/even_regions.h"

#include "cage/remesh/curve_ways.h"
#include "cage/remesh/quad_shape.h"
#include "geom/shortest_paths.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace patchwright::cage {

namespace {

class RegionEvening {
  public:
    RegionEvening(PolygonMesh& polygons, const geom::ModelSurface& reference, Poll& poll)
        : polygons_(polygons), ways_(reference, poll), poll_(poll) {}

    void run() {
        find_regions();
        for (std::size_t region = 0; region < triangles_.size(); ++region)
            if (is_odd(int(region))) join_to_another(int(region));
    }

  private:
    [[nodiscard]] bool is_odd(int region) const {
        return triangles_[std::size_t(region)].size() % 2 == 1;
    }
    /// A whole region between three features: there is nothing better.
    [[nodiscard]] bool is_alone(int polygon) const {
        const auto& c = polygons_.corners(polygon);
        return c.size() == 3 && polygons_.is_feature(c[0], c[1]) &&
               polygons_.is_feature(c[1], c[2]) && polygons_.is_feature(c[2], c[0]);
    }

    void find_regions() {
        const std::vector<int> region = polygons_.regions();
        for (int i = 0; i < polygons_.count(); ++i) {
            const std::size_t size = polygons_.corners(i).size();
            if (size == 0) continue;
            const std::size_t r = std::size_t(region[std::size_t(i)]);
            if (triangles_.size() <= r) triangles_.resize(r + 1);
            if (size == 3 && !is_alone(i)) triangles_[r].push_back(i);
        }
    }

    template <class Visit>
    void for_each_neighbour(int polygon, const Visit& visit) const {
        const auto& c = polygons_.corners(polygon);
        for (std::size_t k = 0; k < c.size(); ++k) {
            const int a = c[k], b = c[(k + 1) % c.size()];
            for (const int other : polygons_.of_edge(a, b))
                if (other != polygon) visit(other, a, b);
        }
    }

    [[nodiscard]] double length(int a, int b) const {
        return (polygons_.mesh().point(a) - polygons_.mesh().point(b)).norm();
    }

    /// Lets the way lead across long edges rather than short ones.
    [[nodiscard]] double cost_of_split(int polygon, int a, int b) const {
        const auto& c = polygons_.corners(polygon);
        double sum = 0.0;
        for (std::size_t k = 0; k < c.size(); ++k) sum += length(c[k], c[(k + 1) % c.size()]);
        return sum / (double(c.size()) * length(a, b));
    }

    void join_to_another(int region) {
        std::vector<std::pair<int, double>> starts;
        for (const int t : triangles_[std::size_t(region)]) starts.emplace_back(t, 0.0);
        const geom::ShortestPaths paths = geom::shortest_paths(
            std::size_t(polygons_.count()), starts, [&](int polygon, double so_far, auto reach) {
                poll_();
                for_each_neighbour(polygon, [&](int other, int a, int b) {
                    if (is_alone(other)) return;
                    const bool feature = polygons_.is_feature(a, b);
                    reach(other, so_far + 1.0 + (feature ? cost_of_split(polygon, a, b) : 0.0));
                });
            });
        double least = std::numeric_limits<double>::infinity();
        int nearest = -1, last = -1;
        for (int other = region + 1; other < int(triangles_.size()); ++other) {
            if (!is_odd(other)) continue;
            for (const int t : triangles_[std::size_t(other)]) {
                if (paths.length[std::size_t(t)] >= least) continue;
                least = paths.length[std::size_t(t)];
                nearest = t;
                last = other;
            }
        }
        if (nearest < 0) return;
        const std::vector<int> path = paths.path_to(nearest);
        std::vector<std::pair<int, int>> crossed;
        for (std::size_t i = 1; i < path.size(); ++i) {
            const auto edge = feature_between(path[i - 1], path[i]);
            if (edge) crossed.push_back(*edge);
        }
        for (const auto& [a, b] : crossed) split(a, b);
        // Even from now on; which triangles they are is not asked again.
        triangles_[std::size_t(region)].clear();
        triangles_[std::size_t(last)].clear();
    }

    /// The longest one; none where they meet elsewhere as well.
    [[nodiscard]] std::optional<std::pair<int, int>> feature_between(int from, int to) const {
        double longest = 0.0;
        std::optional<std::pair<int, int>> edge;
        bool open = false;
        for_each_neighbour(from, [&](int other, int a, int b) {
            if (other != to) return;
            if (!polygons_.is_feature(a, b)) {
                open = true;
            } else if (length(a, b) > longest) {
                longest = length(a, b);
                edge = {a, b};
            }
        });
        return open ? std::nullopt : edge;
    }

    void split(int a, int b) {
        const std::vector<int> beside = polygons_.of_edge(a, b);
        const int made = polygons_.split_feature(a, b, middle(a, b));
        for (const int polygon : beside) {
            if (polygons_.corners(polygon).size() == 5)
                cut_pentagon(polygon);
            else
                cut_triangle(polygon, made);
        }
    }

    [[nodiscard]] geom::Vec3 middle(int a, int b) const {
        const geom::EdgeSides s = polygons_.mesh().sides(a, b);
        const int curve = polygons_.mesh().curve(s.triangle[0], s.side[0]);
        return ways_.middle(curve, polygons_.mesh().point(a), polygons_.mesh().point(b));
    }

    /// Into two, between the new vertex on one side and the opposite corner: one face is not enough
    /// for a vertex inside a curve.
    void cut_triangle(int polygon, int made) {
        const std::vector<int> c = polygons_.corners(polygon);
        const std::size_t k = std::size_t(std::find(c.begin(), c.end(), made) - c.begin());
        const auto at = [&](std::size_t i) { return c[(k + i) % 4]; };
        polygons_.replace(polygon, {at(0), at(1), at(2)});
        polygons_.add({at(0), at(2), at(3)}, polygon);
    }

    /// Into a triangle and a quad, as good as they can be.
    void cut_pentagon(int polygon) {
        const std::vector<int> c = polygons_.corners(polygon);
        const auto p = [&](std::size_t k) { return polygons_.mesh().point(c[k % 5]); };
        double best = -1.0;
        std::size_t tip = 0;
        for (std::size_t k = 0; k < 5; ++k) {
            if (!polygons_.of_edge(c[(k + 4) % 5], c[(k + 1) % 5]).empty()) continue;
            const double worse = std::min(triangle_quality({p(k + 4), p(k), p(k + 1)}),
                                          quad_quality({p(k + 1), p(k + 2), p(k + 3), p(k + 4)}));
            if (worse <= best) continue;
            best = worse;
            tip = k;
        }
        const auto at = [&](std::size_t k) { return c[(tip + k) % 5]; };
        polygons_.replace(polygon, {at(1), at(2), at(3), at(4)});
        polygons_.add({at(4), at(0), at(1)}, polygon);
    }

    PolygonMesh& polygons_;
    CurveWays ways_;
    Poll& poll_;
    std::vector<std::vector<int>> triangles_;  ///< one list a region
};

}  // namespace

void make_regions_even(PolygonMesh& polygons, const geom::ModelSurface& reference, Poll& poll) {
    RegionEvening(polygons, reference, poll).run();
}

}  // namespace patchwright::cage
