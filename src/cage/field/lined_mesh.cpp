#include "cage/field/lined_mesh.h"

#include "geom/angle.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

LinedMesh::LinedMesh(geom::EditableMesh& mesh, CrossField& field)
    : mesh_(mesh), field_(field), on_wall_(at(mesh.vertex_count()), 0) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
        on_wall_[at(v)] = mesh.vertex_alive(v) && !border_neighbours(mesh, v).empty() ? 1 : 0;
}

bool LinedMesh::is_wall(int t, int k) const {
    const auto& c = mesh_.triangle(t);
    return is_feature(t, k) || is_line(c[at(k)], c[at((k + 1) % 3)]);
}

Vec3 LinedMesh::point(const SidePoint& p) const {
    return mesh_.point(p.a) + p.t * (mesh_.point(p.b) - mesh_.point(p.a));
}

int LinedMesh::split(const SidePoint& where) {
    const geom::EdgeSides s = mesh_.sides(where.a, where.b);
    const bool feature = is_feature(s.triangle[0], s.side[0]);
    const int m = mesh_.split(where.a, where.b, point(where));
    for (const int t : s.triangle)
        if (t >= 0) field_.direction.push_back(field_.direction[at(t)]);
    on_wall_.push_back(feature ? 1 : 0);
    const auto known = sides_.find(std::minmax(where.a, where.b));
    if (known == sides_.end()) return m;
    on_wall_[at(m)] = 1;
    std::vector<int>& line = lines_[at(known->second)];
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        if (std::pair<int, int>(std::minmax(line[i], line[i + 1])) == known->first) {
            line.insert(line.begin() + std::ptrdiff_t(i) + 1, m);
            break;
        }
    sides_[std::minmax(where.a, m)] = sides_[std::minmax(m, where.b)] = known->second;
    sides_.erase(std::minmax(where.a, where.b));
    return m;
}

int LinedMesh::add_line() {
    lines_.emplace_back();
    return int(lines_.size()) - 1;
}

void LinedMesh::draw(const std::vector<int>& path, int line) {
    std::vector<int>& whole = lines_[at(line)];
    for (std::size_t i = 0; i < path.size(); ++i) {
        if (!whole.empty() && whole.back() == path[i]) continue;
        if (!whole.empty()) sides_[std::minmax(whole.back(), path[i])] = line;
        whole.push_back(path[i]);
        on_wall_[at(path[i])] = 1;
    }
}

std::vector<VertexFan> LinedMesh::fans(int v) const {
    const auto stops = [&](int a, int b) { return mesh_.is_feature(a, b); };
    const std::vector<int> borders = border_neighbours(mesh_, v);
    if (borders.empty()) return {fan_from(mesh_, v, some_neighbour(mesh_, v), stops)};
    std::vector<VertexFan> result;
    for (const int w : borders) {
        VertexFan fan = fan_from(mesh_, v, w, stops);
        if (!fan.wedges.empty()) result.push_back(std::move(fan));
    }
    return result;
}

PolarPlace LinedMesh::place_of(int v, const Vec3& direction) const {
    PolarPlace best;
    double least = 1e300;
    for (const VertexFan& fan : fans(v)) {
        for (const Wedge& w : fan.wedges) {
            const auto& c = mesh_.triangle(w.triangle);
            const Vec3 from = mesh_.point(w.next) - mesh_.point(v);
            const Vec3 to = mesh_.point(c[at((w.corner + 2) % 3)]) - mesh_.point(v);
            const double after = geom::angle_between(from, direction);
            const double off = after + geom::angle_between(direction, to) - w.angle;
            if (off >= least) continue;
            least = off;
            best = {fan.wedges[0].next, w.start + std::min(after, w.angle), w.triangle};
        }
    }
    return best;
}

Vec3 LinedMesh::direction_at(int v, const VertexFan& fan, double angle) const {
    if (fan.closed) {
        angle = std::fmod(angle, fan.angle);
        if (angle < 0.0) angle += fan.angle;
    }
    std::size_t i = 0;
    while (i + 1 < fan.wedges.size() && fan.wedges[i + 1].start <= angle) ++i;
    const Wedge& w = fan.wedges[i];
    const Vec3 from = (mesh_.point(w.next) - mesh_.point(v)).normalized();
    const Vec3 normal = mesh_.area_vector(w.triangle).normalized();
    const double turn = angle - w.start;
    return std::cos(turn) * from + std::sin(turn) * normal.cross(from);
}

}  // namespace patchwright::cage
