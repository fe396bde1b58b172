#include "cage/remesh/relax_quads.h"

#include "cage/remesh/quad_shape.h"
#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

constexpr int rounds = 12;
// Shares of the way to where a vertex would be best placed, or to its neighbours on a curve.
constexpr std::array<double, 3> smooth_steps{1.0, 0.5, 0.2};
constexpr std::array<double, 3> curve_steps{0.25, 0.1, 0.03};
// By how much the way along a curve to a neighbour may grow in all: curves that bend keep their
// vertices.
constexpr double most_growth = 4.0 / 3.0;
// A face of quality 0 counts as twenty good ones.
constexpr double quality_floor = 0.05;

}  // namespace

void QuadRelaxation::run() {
    find_shared_corners();
    for (int round = 0; round < rounds; ++round)
        for (int v = 0; v < polygons_.mesh().vertex_count(); ++v) {
            if (polygons_.at_vertex(v).empty()) continue;
            if (polygons_.kind(v) == geom::VertexKind::Smooth) relax_smooth(v);
            if (polygons_.kind(v) == geom::VertexKind::Curve) relax_on_curve(v);
        }
}

void QuadRelaxation::find_shared_corners() {
    shared_corners_.assign(std::size_t(polygons_.count()), {});
    for (int v = 0; v < polygons_.mesh().vertex_count(); ++v) {
        if (polygons_.kind(v) != geom::VertexKind::Fixed || polygons_.at_vertex(v).empty())
            continue;
        for (const std::vector<int>& sector : polygons_.sectors(v)) {
            if (sector.size() < 2) continue;
            for (const int polygon : sector) {
                const auto& c = polygons_.corners(polygon);
                shared_corners_[std::size_t(polygon)].push_back(
                    std::size_t(std::find(c.begin(), c.end(), v) - c.begin()));
            }
        }
    }
}

/// Of a polygon with vertex v at p.
double QuadRelaxation::quality(int polygon, int v, const Vec3& p) const {
    const auto& c = polygons_.corners(polygon);
    const std::size_t n = c.size();
    const auto at = [&](std::size_t k) {
        return c[k % n] == v ? p : polygons_.mesh().point(c[k % n]);
    };
    double result = n == 4 ? quad_quality({at(0), at(1), at(2), at(3)})
                           : triangle_quality({at(0), at(1), at(2)});
    for (const std::size_t k : shared_corners_[std::size_t(polygon)])
        result *= evenness(geom::angle_between(at(k + 1) - at(k), at(k + n - 1) - at(k)));
    return result;
}

/// Of the faces around a vertex, with the vertex at p.
double QuadRelaxation::badness(int v, const Vec3& p) const {
    double sum = 0.0;
    for (const int polygon : polygons_.at_vertex(v))
        sum += 1.0 / (quality(polygon, v, p) + quality_floor);
    return sum;
}

Vec3 QuadRelaxation::normal_at(int v) const {
    Vec3 sum = Vec3::Zero();
    for (const int polygon : polygons_.at_vertex(v)) {
        const auto& c = polygons_.corners(polygon);
        for (std::size_t k = 2; k < c.size(); ++k)
            sum += (polygons_.mesh().point(c[k - 1]) - polygons_.mesh().point(c[0]))
                       .cross(polygons_.mesh().point(c[k]) - polygons_.mesh().point(c[0]));
    }
    return sum.normalized();
}

void QuadRelaxation::relax_smooth(int v) {
    const Vec3 normal = normal_at(v);
    const Vec3 here = polygons_.mesh().point(v);
    Vec3 middles = Vec3::Zero(), neighbours = Vec3::Zero();
    double count = 0.0;
    for (const int polygon : polygons_.at_vertex(v)) {
        const auto& c = polygons_.corners(polygon);
        Vec3 middle = Vec3::Zero();
        for (std::size_t k = 0; k < c.size(); ++k) {
            middle += polygons_.mesh().point(c[k]) / double(c.size());
            if (c[k] == v) neighbours += polygons_.mesh().point(c[(k + 1) % c.size()]);
        }
        middles += middle;
        ++count;
    }
    const double now = badness(v, here);
    double best = now;
    Vec3 to = here;
    for (const Vec3& goal : {Vec3(middles / count), Vec3(neighbours / count)}) {
        Vec3 way = goal - here;
        way -= normal.dot(way) * normal;
        for (const double step : smooth_steps) {
            const double there = badness(v, here + step * way);
            if (there < best) {
                best = there;
                to = here + step * way;
            }
        }
    }
    if (!(best < now)) return;
    poll_();
    to = reference_.foot_point(to, normal).point;
    if (badness(v, to) < now) polygons_.move(v, to);
}

void QuadRelaxation::relax_on_curve(int v) {
    const int curve = polygons_.mesh().curve_at(v);
    const double here = ways_.arc_at(curve, polygons_.mesh().point(v));
    const auto next = polygons_.mesh().feature_neighbours(v);
    std::array<double, 2> ways{}, longest{};
    for (std::size_t i = 0; i < 2; ++i) {
        ways[i] = ways_.way(curve, here, ways_.arc_at(curve, polygons_.mesh().point(next[i])));
        const double first =
            first_way_.try_emplace(std::minmax(v, next[i]), std::abs(ways[i])).first->second;
        longest[i] = most_growth * first;
    }
    double best = badness(v, polygons_.mesh().point(v));
    Vec3 to = polygons_.mesh().point(v);
    for (std::size_t i = 0; i < 2; ++i)
        for (const double step : curve_steps) {
            const double moved = step * ways[i];
            if (std::abs(ways[1 - i] - moved) > longest[1 - i]) continue;
            const Vec3 p = reference_.point_on_curve(curve, here + moved).point;
            const double there = badness(v, p);
            if (there < best) {
                best = there;
                to = p;
            }
        }
    polygons_.move(v, to);
}

}  // namespace patchwright::cage
