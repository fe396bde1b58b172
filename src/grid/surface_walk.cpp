#include "grid/surface_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::grid {

using geom::Vec3;
using mesh::CornerId;
using mesh::Topology;
using subd::Location;

namespace {

// Newton's steps: what is left after them is far below what a move changes.
constexpr int most_steps = 8;
constexpr double close_enough = 1e-3;  ///< of the move's length
constexpr int most_crossings = 8;      ///< of faces' sides, in one step
// How far off an extraordinary vertex, where there are no derivatives, a walk begins.
constexpr double off_vertex_by = 0.02;

/// Of a quad's side: direction along it, and into the face.
constexpr std::array<std::array<double, 2>, 4> along{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
constexpr std::array<std::array<double, 2>, 4> into{{{0, 1}, {-1, 0}, {0, -1}, {1, 0}}};

std::size_t side_of(const Topology& t, CornerId c) {
    return std::size_t(c.value - t.corners(t.face(c))[0].value);
}

bool is_vertex(const Location& at) {
    return (at.u == 0.0 || at.u == 1.0) && (at.v == 0.0 || at.v == 1.0);
}

CornerId corner_at(const Topology& t, const Location& at) {
    const int k = at.v == 0.0 ? (at.u == 0.0 ? 0 : 1) : (at.u == 0.0 ? 3 : 2);
    return t.corners(at.face)[k];
}

}  // namespace

bool is_feature(const Topology& topology, CornerId edge) {
    return topology.sharpness(topology.edge(edge)) > 0.0;
}

Location location_of(const Topology& topology, const LinePlace& at) {
    const mesh::FaceId face = topology.face(at.edge);
    switch (side_of(topology, at.edge)) {
        case 0: return {face, at.t, 0.0};
        case 1: return {face, 1.0, at.t};
        case 2: return {face, 1.0 - at.t, 1.0};
        default: return {face, 0.0, 1.0 - at.t};
    }
}

std::optional<NextFeature> next_feature(const Topology& t, mesh::VertexId v, mesh::EdgeId edge) {
    if (t.sharpness(v) > 0.0) return std::nullopt;
    std::optional<NextFeature> found;
    int count = 0;
    const CornerId first = t.corner(v);
    CornerId c = first;
    do {
        if (is_feature(t, c)) {
            ++count;
            if (t.edge(c) != edge) found = NextFeature{c, false};
        }
        // At a border the last half-edge comes in.
        if (const CornerId in = t.previous(c); !t.twin(in).valid()) {
            ++count;
            if (t.edge(in) != edge) found = NextFeature{in, true};
        }
        c = t.rotate(c);
    } while (c.valid() && c != first);
    return count == 2 ? found : std::nullopt;
}

LimitFace& SurfaceWalk::face(mesh::FaceId f) {
    const auto known = faces_.find(f.value);
    if (known != faces_.end()) return known->second;
    return faces_.try_emplace(f.value, table_, cage_, f).first->second;
}

LimitFace::Tangents SurfaceWalk::at(const Location& place) {
    return face(place.face).tangents(place.u, place.v);
}

Vec3 SurfaceWalk::direction(const LinePlace& place) {
    const LimitFace::Tangents at_place = at(location_of(*cage_.topology, place));
    const auto& way = along[side_of(*cage_.topology, place.edge)];
    return way[0] * at_place.du + way[1] * at_place.dv;
}

Location SurfaceWalk::walked(Location place, double du, double dv) const {
    const Topology& t = *cage_.topology;
    for (int crossing = 0; crossing <= most_crossings; ++crossing) {
        // The side that is met first.
        double share = 1.0;
        int side = -1;
        const auto meet = [&](double at, double step, int low, int high) {
            const double to = at + step;
            if (to >= 0.0 && to <= 1.0) return;
            const double s = ((to < 0.0 ? 0.0 : 1.0) - at) / step;
            if (s < share) {
                share = s;
                side = to < 0.0 ? low : high;
            }
        };
        meet(place.u, du, 3, 1);
        meet(place.v, dv, 0, 2);
        place.u = std::clamp(place.u + share * du, 0.0, 1.0);
        place.v = std::clamp(place.v + share * dv, 0.0, 1.0);
        if (side < 0) return place;
        const CornerId out = t.corners(place.face)[side];
        if (crossing == most_crossings || is_feature(t, out)) return place;
        const auto k = std::size_t(side);
        const double rest_u = (1.0 - share) * du, rest_v = (1.0 - share) * dv;
        const double a = rest_u * along[k][0] + rest_v * along[k][1];
        const double b = rest_u * into[k][0] + rest_v * into[k][1];
        const double s = k == 0   ? place.u
                         : k == 1 ? place.v
                         : k == 2 ? 1.0 - place.u
                                  : 1.0 - place.v;
        const CornerId in = t.twin(out);
        const std::size_t m = side_of(t, in);
        place = location_of(t, {in, 1.0 - s});
        du = -a * along[m][0] - b * into[m][0];
        dv = -a * along[m][1] - b * into[m][1];
    }
    return place;
}

Location SurfaceWalk::off_vertex(const Location& place, const Vec3& by) {
    const Topology& t = *cage_.topology;
    const Vec3 here = at(place).point;
    const CornerId first = corner_at(t, place);
    Location best = place;
    double most = 0.0;
    CornerId c = first;
    do {
        const auto k = side_of(t, c);
        const Location corner = location_of(t, {c, 0.0});
        const auto& a = along[k];
        const auto& b = into[k];
        const Location near{corner.face, corner.u + off_vertex_by * (a[0] + b[0]),
                            corner.v + off_vertex_by * (a[1] + b[1])};
        const Vec3 way = at(near).point - here;
        const double seen = way.dot(by) / std::max(way.norm(), 1e-300);
        if (seen > most) {
            most = seen;
            best = near;
        }
        c = t.rotate(c);
    } while (c.valid() && c != first);
    return best;
}

Location SurfaceWalk::moved(const Location& from, const Vec3& by) {
    if (by.isZero(0.0)) return from;
    Location place = from;
    const Vec3 target = at(place).point + by;
    if (is_vertex(place)) place = off_vertex(place, by);
    for (int step = 0; step < most_steps; ++step) {
        const LimitFace::Tangents s = at(place);
        const Vec3 left = target - s.point;
        const double a = s.du.squaredNorm(), b = s.du.dot(s.dv), c = s.dv.squaredNorm();
        const double e = s.du.dot(left), f = s.dv.dot(left);
        const double determinant = a * c - b * b;
        if (!(determinant > 1e-12 * a * c)) break;
        double du = (c * e - b * f) / determinant, dv = (a * f - b * e) / determinant;
        if ((du * s.du + dv * s.dv).norm() < close_enough * by.norm()) break;
        const double size = std::max(std::abs(du), std::abs(dv));
        if (size > 1.0) du /= size, dv /= size;
        place = walked(place, du, dv);
    }
    return place;
}

LinePlace SurfaceWalk::walked(LinePlace place, double dt) const {
    const Topology& t = *cage_.topology;
    for (int crossing = 0; crossing <= most_crossings; ++crossing) {
        const double to = place.t + dt;
        if (to >= 0.0 && to <= 1.0) return {place.edge, to};
        const bool forward = to > 1.0;
        place.t = forward ? 1.0 : 0.0;
        const CornerId end = forward ? t.next(place.edge) : place.edge;
        const auto next = next_feature(t, t.vertex(end), t.edge(place.edge));
        if (!next) return place;
        const double rest = std::abs(to - place.t);
        place = {next->edge, next->reversed ? 1.0 : 0.0};
        dt = next->reversed ? -rest : rest;
    }
    return place;
}

LinePlace SurfaceWalk::moved(const LinePlace& from, const Vec3& by) {
    if (by.isZero(0.0)) return from;
    LinePlace place = from;
    const Vec3 target = at(location_of(*cage_.topology, place)).point + by;
    for (int step = 0; step < most_steps; ++step) {
        const Vec3 way = direction(place);
        const double square = way.squaredNorm();
        if (!(square > 0.0)) break;
        const Vec3 left = target - at(location_of(*cage_.topology, place)).point;
        const double dt = std::clamp(left.dot(way) / square, -1.0, 1.0);
        if (std::abs(dt) * std::sqrt(square) < close_enough * by.norm()) break;
        place = walked(place, dt);
    }
    return place;
}

}  // namespace patchwright::grid
