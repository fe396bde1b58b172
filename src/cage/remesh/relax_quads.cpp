#include "cage/remesh/relax_quads.h"

#include "cage/remesh/quad_shape.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>

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

class QuadRelaxation {
  public:
    QuadRelaxation(const Polygons& polygons, geom::EditableMesh& mesh,
                   const geom::ModelSurface& reference, Poll& poll)
        : polygons_(polygons),
          mesh_(mesh),
          reference_(reference),
          poll_(poll),
          at_vertex_(std::size_t(mesh.vertex_count())) {
        for (std::size_t i = 0; i < polygons.corners.size(); ++i)
            for (const int v : polygons.corners[i]) at_vertex_[std::size_t(v)].push_back(int(i));
    }

    void run() {
        for (int round = 0; round < rounds; ++round)
            for (int v = 0; v < mesh_.vertex_count(); ++v) {
                if (at_vertex_[std::size_t(v)].empty()) continue;
                if (mesh_.kind(v) == geom::VertexKind::Smooth) relax_smooth(v);
                if (mesh_.kind(v) == geom::VertexKind::Curve) relax_on_curve(v);
            }
    }

  private:
    [[nodiscard]] const std::vector<int>& corners(int polygon) const {
        return polygons_.corners[std::size_t(polygon)];
    }

    /// Of the faces around a vertex, with the vertex at p.
    [[nodiscard]] double badness(int v, const Vec3& p) const {
        double sum = 0.0;
        for (const int polygon : at_vertex_[std::size_t(v)]) {
            const auto& c = corners(polygon);
            const auto at = [&](std::size_t k) { return c[k] == v ? p : mesh_.point(c[k]); };
            const double quality = c.size() == 4 ? quad_quality({at(0), at(1), at(2), at(3)})
                                                 : triangle_quality({at(0), at(1), at(2)});
            sum += 1.0 / (quality + quality_floor);
        }
        return sum;
    }

    [[nodiscard]] Vec3 normal_at(int v) const {
        Vec3 sum = Vec3::Zero();
        for (const int polygon : at_vertex_[std::size_t(v)]) {
            const auto& c = corners(polygon);
            for (std::size_t k = 2; k < c.size(); ++k)
                sum += (mesh_.point(c[k - 1]) - mesh_.point(c[0]))
                           .cross(mesh_.point(c[k]) - mesh_.point(c[0]));
        }
        return sum.normalized();
    }

    void relax_smooth(int v) {
        const Vec3 normal = normal_at(v);
        const Vec3 here = mesh_.point(v);
        Vec3 middles = Vec3::Zero(), neighbours = Vec3::Zero();
        double count = 0.0;
        for (const int polygon : at_vertex_[std::size_t(v)]) {
            const auto& c = corners(polygon);
            Vec3 middle = Vec3::Zero();
            for (std::size_t k = 0; k < c.size(); ++k) {
                middle += mesh_.point(c[k]) / double(c.size());
                if (c[k] == v) neighbours += mesh_.point(c[(k + 1) % c.size()]);
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
        if (badness(v, to) < now) mesh_.move(v, to);
    }

    [[nodiscard]] double arc_at(int curve, int v) const {
        poll_();
        return reference_.nearest_on_curve(curve, mesh_.point(v)).arc_length;
    }
    /// Along a curve; on closed ones the shorter way, either of which may be negative.
    [[nodiscard]] double way(int curve, double from, double to) const {
        const geom::FeatureCurve& c = reference_.features().curves[std::size_t(curve)];
        return c.closed ? std::remainder(to - from, c.length) : to - from;
    }

    void relax_on_curve(int v) {
        const int curve = mesh_.curve_at(v);
        const double here = arc_at(curve, v);
        const auto next = mesh_.feature_neighbours(v);
        std::array<double, 2> ways{}, longest{};
        for (std::size_t i = 0; i < 2; ++i) {
            ways[i] = way(curve, here, arc_at(curve, next[i]));
            const double first =
                first_way_.try_emplace(std::minmax(v, next[i]), std::abs(ways[i])).first->second;
            longest[i] = most_growth * first;
        }
        double best = badness(v, mesh_.point(v));
        Vec3 to = mesh_.point(v);
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
        mesh_.move(v, to);
    }

    const Polygons& polygons_;
    geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    std::vector<std::vector<int>> at_vertex_;          ///< polygons
    std::map<std::pair<int, int>, double> first_way_;  ///< ways along curves at first, millimetres
};

}  // namespace

void relax_quads(const Polygons& polygons, geom::EditableMesh& mesh,
                 const geom::ModelSurface& reference, Poll& poll) {
    QuadRelaxation(polygons, mesh, reference, poll).run();
}

}  // namespace patchwright::cage
