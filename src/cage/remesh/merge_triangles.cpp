#include "cage/remesh/merge_triangles.h"

#include "cage/remesh/quad_shape.h"
#include "geom/angle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>

namespace patchwright::cage {

namespace {

using Triangle = std::array<int, 3>;
using Quad = std::array<int, 4>;

// Sum over the new quads of a way of 1 / quality - 1, as they are before vertices are relaxed:
// twenty quads of quality 1/2, or one that is hardly convex. More are hard to bring into shape.
constexpr double most_cost = 20.0;
// Ways that are looked at from a triangle, at most.
constexpr int most_ways = 3000;

/// A step of a triangle: through a quad, which leaves another quad there, or onto a triangle.
struct Step {
    double cost;  ///< of the way so far
    int before;   ///< step; -1: none
    int polygon;  ///< that is gone through
    Quad quad;    ///< that is there afterwards
    Triangle triangle;
    bool arrived;
};

class TriangleMerging {
  public:
    TriangleMerging(Polygons& polygons, const geom::EditableMesh& mesh, Poll& poll)
        : polygons_(polygons),
          mesh_(mesh),
          poll_(poll),
          at_vertex_(std::size_t(mesh.vertex_count())) {
        for (std::size_t i = 0; i < polygons_.corners.size(); ++i) add(int(i));
    }

    void run() {
        for (std::size_t i = 0; i < polygons_.corners.size(); ++i)
            if (polygons_.corners[i].size() == 3) move_triangle(int(i));
        remove_empty();
    }

  private:
    static std::pair<int, int> key(int a, int b) { return std::minmax(a, b); }

    void add(int polygon) {
        const auto& c = polygons_.corners[std::size_t(polygon)];
        for (std::size_t k = 0; k < c.size(); ++k) {
            of_edge_[key(c[k], c[(k + 1) % c.size()])].push_back(polygon);
            at_vertex_[std::size_t(c[k])].push_back(polygon);
        }
    }

    void remove(int polygon) {
        const auto& c = polygons_.corners[std::size_t(polygon)];
        for (std::size_t k = 0; k < c.size(); ++k) {
            const auto edge = of_edge_.find(key(c[k], c[(k + 1) % c.size()]));
            std::erase(edge->second, polygon);
            if (edge->second.empty()) of_edge_.erase(edge);
            std::erase(at_vertex_[std::size_t(c[k])], polygon);
        }
    }

    void replace(int polygon, std::vector<int> corners) {
        remove(polygon);
        polygons_.corners[std::size_t(polygon)] = std::move(corners);
        add(polygon);
    }

    [[nodiscard]] double cost_of(const Quad& q) const {
        const double quality = quad_quality(
            {mesh_.point(q[0]), mesh_.point(q[1]), mesh_.point(q[2]), mesh_.point(q[3])});
        return quality > 0.0 ? 1.0 / quality - 1.0 : most_cost;
    }

    [[nodiscard]] bool on_way(int step, int start, int polygon) const {
        for (; step >= 0; step = steps_[std::size_t(step)].before)
            if (steps_[std::size_t(step)].polygon == polygon) return true;
        return polygon == start;
    }

    void push(Step step) {
        if (step.cost >= most_cost) return;
        queue_.emplace(step.cost, int(steps_.size()));
        steps_.push_back(step);
    }

    /// All steps from a triangle that step `before` leaves, across side k.
    void leave(int before, int start, const Triangle& t, std::size_t k, double cost) {
        const int a = t[k], b = t[(k + 1) % 3], tip = t[(k + 2) % 3];
        const auto edge = of_edge_.find(key(a, b));
        if (edge == of_edge_.end() || mesh_.is_feature(a, b)) return;
        for (const int polygon : edge->second) {
            if (on_way(before, start, polygon)) continue;
            const auto& c = polygons_.corners[std::size_t(polygon)];
            // Counter-clockwise from b to a.
            const std::size_t from = std::size_t(std::find(c.begin(), c.end(), a) - c.begin());
            if (c[(from + c.size() - 1) % c.size()] != b) continue;
            if (c.size() == 3) {
                const Quad merged{a, c[(from + 1) % 3], b, tip};
                push({cost + cost_of(merged), before, polygon, merged, {}, true});
                continue;
            }
            const std::array<int, 5> pentagon{a, c[(from + 1) % 4], c[(from + 2) % 4], b, tip};
            for (std::size_t ear = 0; ear < 4; ++ear) {
                const auto at = [&](std::size_t i) { return pentagon[(ear + i) % 5]; };
                if (of_edge_.count(key(at(4), at(1))) > 0) continue;
                const Quad quad{at(1), at(2), at(3), at(4)};
                push({cost + cost_of(quad), before, polygon, quad, {at(4), at(0), at(1)}, false});
            }
        }
    }

    void move_triangle(int start) {
        steps_.clear();
        queue_ = {};
        std::set<std::pair<int, Triangle>> seen;
        const auto& c = polygons_.corners[std::size_t(start)];
        const Triangle first{c[0], c[1], c[2]};
        for (std::size_t k = 0; k < 3; ++k) leave(-1, start, first, k, 0.0);
        for (int ways = 0; ways < most_ways && !queue_.empty(); ++ways) {
            poll_();
            const int next = queue_.top().second;
            queue_.pop();
            const Step step = steps_[std::size_t(next)];
            if (step.arrived) {
                if (taken(next, start)) return;
                continue;
            }
            if (!seen.emplace(step.polygon, step.triangle).second) continue;
            for (std::size_t k = 0; k < 3; ++k) leave(next, start, step.triangle, k, step.cost);
        }
    }

    /// Takes a way unless a vertex that was sound is not then.
    bool taken(int last, int start) {
        std::vector<std::pair<int, std::vector<int>>> before;
        before.emplace_back(start, polygons_.corners[std::size_t(start)]);
        for (int s = last; s >= 0; s = steps_[std::size_t(s)].before) {
            const Step& step = steps_[std::size_t(s)];
            before.emplace_back(step.polygon, polygons_.corners[std::size_t(step.polygon)]);
        }
        std::set<int> vertices;
        for (const auto& [polygon, corners] : before)
            for (const int v : corners)
                if (is_sound(v)) vertices.insert(v);
        replace(start, {});
        for (int s = last; s >= 0; s = steps_[std::size_t(s)].before) {
            const Step& step = steps_[std::size_t(s)];
            replace(step.polygon, {step.quad.begin(), step.quad.end()});
        }
        const bool apart = std::all_of(before.begin(), before.end(), [&](const auto& one) {
            return shares_edges_only(one.first);
        });
        if (apart &&
            std::all_of(vertices.begin(), vertices.end(), [&](int v) { return is_sound(v); }))
            return true;
        for (auto& [polygon, corners] : before) replace(polygon, std::move(corners));
        return false;
    }

    /// Whether a polygon has at most two vertices in common with any neighbour, and one neighbour
    /// across each edge.
    [[nodiscard]] bool shares_edges_only(int polygon) const {
        const auto& c = polygons_.corners[std::size_t(polygon)];
        for (std::size_t k = 0; k < c.size(); ++k)
            if (of_edge_.at(key(c[k], c[(k + 1) % c.size()])).size() > 2) return false;
        std::map<int, int> common;
        for (const int v : c)
            for (const int other : at_vertex_[std::size_t(v)])
                if (other != polygon && ++common[other] > 2) return false;
        return true;
    }

    [[nodiscard]] double angle_at(int polygon, int v) const {
        const auto& c = polygons_.corners[std::size_t(polygon)];
        const std::size_t k = std::size_t(std::find(c.begin(), c.end(), v) - c.begin());
        return geom::angle_between(mesh_.point(c[(k + 1) % c.size()]) - mesh_.point(v),
                                   mesh_.point(c[(k + c.size() - 1) % c.size()]) - mesh_.point(v));
    }

    /// Whether a vertex has enough faces, evenly wide, in each sector between features.
    [[nodiscard]] bool is_sound(int v) const {
        std::vector<int> left = at_vertex_[std::size_t(v)];
        const bool boundary = mesh_.is_boundary(v);
        if (left.size() < (boundary ? 1 : 3)) return false;
        while (!left.empty()) {
            std::vector<int> sector{left.back()};
            left.pop_back();
            double angle = 0.0, widest = 0.0;
            for (std::size_t i = 0; i < sector.size(); ++i) {
                const double here = angle_at(sector[i], v);
                angle += here;
                widest = std::max(widest, here);
                for (const int w : neighbours_in(sector[i], v)) {
                    if (mesh_.is_feature(v, w)) continue;
                    for (const int other : of_edge_.at(key(v, w))) {
                        const auto found = std::find(left.begin(), left.end(), other);
                        if (found == left.end()) continue;
                        sector.push_back(other);
                        left.erase(found);
                    }
                }
            }
            if (int(sector.size()) < least_faces(mesh_.kind(v), boundary, angle) ||
                !is_even_enough(mesh_.kind(v), widest, angle))
                return false;
        }
        return true;
    }

    [[nodiscard]] std::array<int, 2> neighbours_in(int polygon, int v) const {
        const auto& c = polygons_.corners[std::size_t(polygon)];
        const std::size_t k = std::size_t(std::find(c.begin(), c.end(), v) - c.begin());
        return {c[(k + 1) % c.size()], c[(k + c.size() - 1) % c.size()]};
    }

    void remove_empty() {
        Polygons kept;
        for (std::size_t i = 0; i < polygons_.corners.size(); ++i) {
            if (polygons_.corners[i].empty()) continue;
            kept.corners.push_back(std::move(polygons_.corners[i]));
            kept.faces.push_back(polygons_.faces[i]);
        }
        polygons_ = std::move(kept);
    }

    Polygons& polygons_;
    const geom::EditableMesh& mesh_;
    Poll& poll_;
    std::vector<std::vector<int>> at_vertex_;                  ///< polygons
    std::map<std::pair<int, int>, std::vector<int>> of_edge_;  ///< polygons
    std::vector<Step> steps_;
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>>
        queue_;
};

}  // namespace

void merge_triangles(Polygons& polygons, const geom::EditableMesh& mesh, Poll& poll) {
    TriangleMerging(polygons, mesh, poll).run();
}

}  // namespace patchwright::cage
