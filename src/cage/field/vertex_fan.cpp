#include "cage/field/vertex_fan.h"

#include <patchwright/base/numbers.h>

namespace patchwright::cage {

using base::at;

VertexFan fan_from(const geom::EditableMesh& mesh, int v, int first, const StopsAt& stops) {
    VertexFan fan;
    const geom::EdgeSides sides = mesh.sides(v, first);
    int t = -1, k = -1;
    for (const int candidate : sides.triangle) {
        if (candidate < 0) continue;
        const int corner = mesh.corner_of(candidate, v);
        if (mesh.triangle(candidate)[at((corner + 1) % 3)] != first) continue;
        t = candidate;
        k = corner;
    }
    while (t >= 0) {
        const auto& c = mesh.triangle(t);
        const double angle = mesh.corner_angle(t, k);
        fan.wedges.push_back({t, k, c[at((k + 1) % 3)], fan.angle, angle});
        fan.angle += angle;
        fan.last = c[at((k + 2) % 3)];
        if (fan.last == first) {
            fan.closed = !stops(v, first);
            break;
        }
        if (stops(v, fan.last)) break;
        t = across(mesh, t, (k + 2) % 3);
        if (t >= 0) k = mesh.corner_of(t, v);
    }
    return fan;
}

bool is_border(const geom::EditableMesh& mesh, int t, int k) {
    return mesh.curve(t, k) >= 0 || across(mesh, t, k) < 0;
}

int across(const geom::EditableMesh& mesh, int t, int k) {
    const auto& c = mesh.triangle(t);
    const geom::EdgeSides s = mesh.sides(c[at(k)], c[at((k + 1) % 3)]);
    return s.triangle[0] == t ? s.triangle[1] : s.triangle[0];
}

std::vector<int> border_neighbours(const geom::EditableMesh& mesh, int v) {
    std::vector<int> result;
    for (const int t : mesh.fan(v)) {
        const int k = mesh.corner_of(t, v);
        const auto& c = mesh.triangle(t);
        // Each side once: the one that leaves v, and on the boundary the one that arrives.
        if (is_border(mesh, t, k)) result.push_back(c[at((k + 1) % 3)]);
        if (across(mesh, t, (k + 2) % 3) < 0) result.push_back(c[at((k + 2) % 3)]);
    }
    return result;
}

int some_neighbour(const geom::EditableMesh& mesh, int v) {
    const int t = mesh.fan(v).front();
    return mesh.triangle(t)[at((mesh.corner_of(t, v) + 1) % 3)];
}

}  // namespace patchwright::cage
