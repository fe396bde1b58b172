#include "cage/field/field_nodes.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Fewest quads around a vertex of a cage.
constexpr int least_valence = 3;

/// The angle of the first port of a singularity, from the fan's first side: the one that fits the
/// field best all around.
double first_port(const LinedMesh& lined, int v, const VertexFan& fan, int valence) {
    const geom::EditableMesh& mesh = lined.mesh();
    std::complex<double> sum = 0.0;
    for (const Wedge& w : fan.wedges) {
        const double middle = w.start + 0.5 * w.angle;
        const Vec3 radial = lined.direction_at(v, fan, middle);
        const Vec3 normal = mesh.area_vector(w.triangle).normalized();
        const Vec3& d = lined.direction(w.triangle);
        const double turn = std::atan2(normal.cross(radial).dot(d), radial.dot(d));
        sum += w.angle * std::polar(1.0, 4.0 * turn + valence * 2.0 * M_PI * middle / fan.angle);
    }
    return std::arg(sum) / valence * fan.angle / (2.0 * M_PI);
}

class NodeMaker {
  public:
    explicit NodeMaker(const LinedMesh& lined) : lined_(lined) {}

    FieldNodes make(const FieldTopology& topology) {
        for (const Singularity& s : topology.singularities) {
            const VertexFan fan = lined_.fans(s.vertex).front();
            const int count = std::max(s.valence, least_valence);
            const double first = first_port(lined_, s.vertex, fan, count);
            for (int k = 0; k < count; ++k) add(s.vertex, fan, first + fan.angle * k / count);
        }
        for (const FieldSector& s : topology.sectors) {
            if (s.quads < 2) continue;
            for (const VertexFan& fan : lined_.fans(s.vertex)) {
                if (fan.wedges[0].next != s.next || s.quads < 3) continue;
                for (int k = 1; k < s.quads; ++k) add(s.vertex, fan, fan.angle * k / s.quads);
            }
        }
        return std::move(nodes_);
    }

  private:
    void add(int v, const VertexFan& fan, double angle) {
        const auto [it, added] = number_.emplace(v, int(nodes_.vertex.size()));
        if (added) {
            nodes_.vertex.push_back(v);
            nodes_.ports_of.emplace_back();
        }
        nodes_.ports_of[at(it->second)].push_back(int(nodes_.ports.size()));
        nodes_.ports.push_back({it->second, {v, lined_.direction_at(v, fan, angle)}, false});
    }

    const LinedMesh& lined_;
    std::map<int, int> number_;
    FieldNodes nodes_;
};

}  // namespace

FieldNodes field_nodes(const LinedMesh& lined, const FieldTopology& topology) {
    return NodeMaker(lined).make(topology);
}

}  // namespace patchwright::cage
