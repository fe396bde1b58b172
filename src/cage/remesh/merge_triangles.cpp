#include "cage/remesh/merge_triangles.h"

#include "cage/remesh/quad_shape.h"

#include <algorithm>
#include <map>
#include <queue>
#include <set>

namespace patchwright::cage {

namespace {

using Triangle = std::array<int, 3>;
using Quad = std::array<int, 4>;

// Sum over the new quads of a way of 1 / quality - 1, as they are before vertices are relaxed: a
// hundred quads of quality 1/2, or one of 0.01, which is hardly convex.
constexpr double most_cost = 100.0;
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
    TriangleMerging(PolygonMesh& polygons, Poll& poll)
        : polygons_(polygons), mesh_(polygons.mesh()), poll_(poll) {}

    bool run() {
        bool any = false;
        for (int i = 0; i < polygons_.count(); ++i)
            if (polygons_.corners(i).size() == 3 && move_triangle(i)) any = true;
        return any;
    }

  private:
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
        if (polygons_.of_edge(a, b).empty() || polygons_.is_feature(a, b)) return;
        for (const int polygon : polygons_.of_edge(a, b)) {
            if (on_way(before, start, polygon)) continue;
            const auto& c = polygons_.corners(polygon);
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
                if (!polygons_.of_edge(at(4), at(1)).empty()) continue;
                const Quad quad{at(1), at(2), at(3), at(4)};
                push({cost + cost_of(quad), before, polygon, quad, {at(4), at(0), at(1)}, false});
            }
        }
    }

    bool move_triangle(int start) {
        steps_.clear();
        queue_ = {};
        std::set<std::pair<int, Triangle>> seen;
        const auto& c = polygons_.corners(start);
        const Triangle first{c[0], c[1], c[2]};
        for (std::size_t k = 0; k < 3; ++k) leave(-1, start, first, k, 0.0);
        for (int ways = 0; ways < most_ways && !queue_.empty(); ++ways) {
            poll_();
            const int next = queue_.top().second;
            queue_.pop();
            const Step step = steps_[std::size_t(next)];
            if (step.arrived) {
                if (taken(next, start)) return true;
                continue;
            }
            if (!seen.emplace(step.polygon, step.triangle).second) continue;
            for (std::size_t k = 0; k < 3; ++k) leave(next, start, step.triangle, k, step.cost);
        }
        return false;
    }

    /// Takes a way unless a vertex has more flaws then.
    bool taken(int last, int start) {
        std::vector<std::pair<int, std::vector<int>>> before;
        before.emplace_back(start, polygons_.corners(start));
        for (int s = last; s >= 0; s = steps_[std::size_t(s)].before) {
            const Step& step = steps_[std::size_t(s)];
            before.emplace_back(step.polygon, polygons_.corners(step.polygon));
        }
        std::map<int, int> flaws;
        for (const auto& [polygon, corners] : before)
            for (const int v : corners) flaws[v] = polygons_.flaws(v);
        polygons_.replace(start, {});
        for (int s = last; s >= 0; s = steps_[std::size_t(s)].before) {
            const Step& step = steps_[std::size_t(s)];
            polygons_.replace(step.polygon, {step.quad.begin(), step.quad.end()});
        }
        const bool apart = std::all_of(before.begin(), before.end(), [&](const auto& one) {
            return polygons_.shares_edges_only(one.first);
        });
        if (apart && std::all_of(flaws.begin(), flaws.end(), [&](const auto& one) {
                return polygons_.flaws(one.first) <= one.second;
            }))
            return true;
        for (auto& [polygon, corners] : before) polygons_.replace(polygon, std::move(corners));
        return false;
    }

    PolygonMesh& polygons_;
    const geom::EditableMesh& mesh_;
    Poll& poll_;
    std::vector<Step> steps_;
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>>
        queue_;
};

}  // namespace

bool merge_triangles(PolygonMesh& polygons, Poll& poll) {
    return TriangleMerging(polygons, poll).run();
}

}  // namespace patchwright::cage
