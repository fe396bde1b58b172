#include "cage/field/line_sectors.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

Vec3 side_direction(const LinedMesh& lined, int v, int next) {
    return (lined.mesh().point(next) - lined.mesh().point(v)).normalized();
}

/// Parts a fan that makes room for some quads where lines leave it.
void part_fan(const LinedMesh& lined, int v, const VertexFan& fan, int quads,
              std::vector<FieldSector>& result) {
    std::vector<FieldSector> parts;
    std::vector<double> start;
    for (const Wedge& w : fan.wedges) {
        if (parts.empty() || lined.is_line(v, w.next)) {
            parts.push_back({v, w.next, 0.0, 1});
            start.push_back(w.start);
        }
        parts.back().angle += w.angle;
    }
    const int count = int(parts.size());
    // By angle, each one at least.
    int given = 0;
    for (int i = 0; i < count; ++i) {
        const double end = i + 1 < count ? start[at(i + 1)] : fan.angle;
        const int upto = std::clamp(int(std::lround(quads * end / fan.angle)), given + 1,
                                    std::max(given + 1, quads - (count - i - 1)));
        parts[at(i)].quads = upto - given;
        given = upto;
    }
    result.insert(result.end(), parts.begin(), parts.end());
}

}  // namespace

SectorCounts::SectorCounts(const LinedMesh& lined, const FieldTopology& topology) {
    for (const FieldSector& s : topology.sectors)
        at_borders_[s.vertex].push_back({side_direction(lined, s.vertex, s.next), s.quads});
    for (const Singularity& s : topology.singularities) valence_[s.vertex] = std::max(s.valence, 3);
}

int SectorCounts::quads_of(const LinedMesh& lined, int v, int next) const {
    const auto known = at_borders_.find(v);
    if (known == at_borders_.end()) return 2;
    const Vec3 d = side_direction(lined, v, next);
    const auto best = std::max_element(
        known->second.begin(), known->second.end(),
        [&](const Known& a, const Known& b) { return a.direction.dot(d) < b.direction.dot(d); });
    return best->quads;
}

std::vector<FieldSector> SectorCounts::sectors(const LinedMesh& lined) const {
    const geom::EditableMesh& mesh = lined.mesh();
    // The line that passes a vertex first, if there is one, bears those that end there.
    std::map<int, std::set<int>> passing;
    std::set<int> looked_at;
    for (const auto& line : lined.lines()) {
        for (std::size_t i = 0; i < line.size(); ++i) {
            const bool inside = i > 0 && i + 1 < line.size();
            if (inside && !passing.contains(line[i]))
                passing[line[i]] = {line[i - 1], line[i + 1]};
            else
                looked_at.insert(line[i]);
        }
    }
    for (const auto& [v, known] : at_borders_) looked_at.insert(v);
    std::vector<FieldSector> result;
    const auto features = [&](int a, int b) { return mesh.is_feature(a, b); };
    for (const int v : looked_at) {
        const std::vector<int> borders = border_neighbours(mesh, v);
        if (!borders.empty()) {
            for (const int w : borders) {
                const VertexFan fan = fan_from(mesh, v, w, features);
                if (!fan.wedges.empty()) part_fan(lined, v, fan, quads_of(lined, v, w), result);
            }
            continue;
        }
        const auto line = passing.find(v);
        if (const auto singular = valence_.find(v); singular != valence_.end()) {
            for (const int w : mesh.neighbours(v)) {
                if (!lined.is_line(v, w)) continue;
                part_fan(lined, v, fan_from(mesh, v, w, [](int, int) { return false; }),
                         singular->second, result);
                break;
            }
            continue;
        }
        if (line == passing.end()) continue;
        const auto stops = [&](int a, int b) { return line->second.contains(a == v ? b : a); };
        for (const int w : line->second) part_fan(lined, v, fan_from(mesh, v, w, stops), 2, result);
    }
    return result;
}

}  // namespace patchwright::cage
