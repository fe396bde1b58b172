#include "cage/field/field_topology.h"

#include "cage/field/vertex_fan.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace patchwright::cage {

using base::at;

namespace {

/// Sums over the region between features that a triangle is in.
struct RegionSum {
    int quarters = 0;  ///< of indices, inner vertices and sectors
    int euler = 0;
    int seed = -1;
};

class TopologyFinder {
  public:
    TopologyFinder(const geom::EditableMesh& mesh, const CrossField& field)
        : mesh_(mesh), field_(field), region_(at(mesh.triangle_count()), -1) {
        find_regions();
    }

    FieldTopology find() {
        const auto stops = [&](int a, int b) { return mesh_.is_feature(a, b); };
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            if (!mesh_.vertex_alive(v)) continue;
            const std::vector<int> borders = border_neighbours(mesh_, v);
            if (borders.empty()) {
                add_inner(v, fan_from(mesh_, v, some_neighbour(mesh_, v), stops));
                continue;
            }
            for (const int w : borders) {
                const VertexFan fan = fan_from(mesh_, v, w, stops);
                if (!fan.wedges.empty()) add_sector(v, w, fan);
            }
        }
        open_points();
        check_regions();
        return std::move(result_);
    }

  private:
    void find_regions() {
        for (int seed = 0; seed < mesh_.triangle_count(); ++seed) {
            if (!mesh_.alive(seed) || region_[at(seed)] >= 0) continue;
            const int number = int(sums_.size());
            RegionSum& sum = sums_.emplace_back();
            sum.seed = seed;
            std::vector<int> all{seed};
            region_[at(seed)] = number;
            int borders = 0;
            for (std::size_t i = 0; i < all.size(); ++i) {
                for (int k = 0; k < 3; ++k) {
                    if (is_border(mesh_, all[i], k)) {
                        ++borders;
                        continue;
                    }
                    const int u = across(mesh_, all[i], k);
                    if (region_[at(u)] >= 0) continue;
                    region_[at(u)] = number;
                    all.push_back(u);
                }
            }
            // Faces less edges; vertices are added where they are looked at.
            sum.euler = int(all.size()) - (3 * int(all.size()) - borders) / 2 - borders;
        }
    }

    /// How much the field turns along a fan, radians.
    [[nodiscard]] double turn_along(const VertexFan& fan) const {
        double turn = 0.0;
        for (std::size_t i = 0; i + 1 < fan.wedges.size(); ++i)
            turn += field_turn(mesh_, field_, fan.wedges[i].triangle, fan.wedges[i + 1].triangle);
        if (fan.closed)
            turn += field_turn(mesh_, field_, fan.wedges.back().triangle, fan.wedges[0].triangle);
        return turn;
    }

    void add_inner(int v, const VertexFan& fan) {
        const double rotation = 2.0 * M_PI - fan.angle + turn_along(fan);
        const int quarters = int(std::lround(rotation / (0.5 * M_PI)));
        // A cone's tip needs lines even where four quads have room.
        if (quarters != 0 || mesh_.corner(v) >= 0)
            result_.singularities.push_back({v, 4 - quarters});
        RegionSum& sum = sums_[at(region_[at(fan.wedges[0].triangle)])];
        sum.quarters += quarters;
        ++sum.euler;
    }

    void add_sector(int v, int first, const VertexFan& fan) {
        const int quads = int(std::lround((fan.angle - turn_along(fan)) / (0.5 * M_PI)));
        // Around the end of a feature there are three at least.
        const bool end = border_neighbours(mesh_, v).size() == 1;
        result_.sectors.push_back({v, first, fan.angle, std::max(quads, end ? 3 : 1), quads});
        RegionSum& sum = sums_[at(region_[at(fan.wedges[0].triangle)])];
        sum.quarters += 2 - quads;
        ++sum.euler;
    }

    /// Where a feature turns smoothly but so fast that both sides have room for one quad only, as
    /// at a thin tip, the wider side gets two: else these two would share two edges along a smooth
    /// line.
    void open_points() {
        std::map<int, std::vector<FieldSector*>> at_vertex;
        for (FieldSector& s : result_.sectors) at_vertex[s.vertex].push_back(&s);
        for (const auto& [v, sectors] : at_vertex) {
            if (sectors.size() != 2 || mesh_.corner(v) >= 0) continue;
            if (sectors[0]->quads > 1 || sectors[1]->quads > 1) continue;
            sectors[sectors[0]->angle < sectors[1]->angle ? 1 : 0]->quads = 2;
        }
    }

    void check_regions() {
        for (const RegionSum& sum : sums_) {
            if (sum.quarters == 4 * sum.euler) continue;
            const auto& c = mesh_.triangle(sum.seed);
            const geom::Vec3& p = mesh_.point(c[0]);
            result_.mismatches.push_back(fmt::format(
                "the field's indices sum up to {}/4, not to the Euler characteristic {}, on the "
                "surface near ({:.4g}, {:.4g}, {:.4g})",
                sum.quarters, sum.euler, p.x(), p.y(), p.z()));
        }
    }

    const geom::EditableMesh& mesh_;
    const CrossField& field_;
    std::vector<int> region_;
    std::vector<RegionSum> sums_;
    FieldTopology result_;
};

}  // namespace

FieldTopology field_topology(const geom::EditableMesh& mesh, const CrossField& field) {
    return TopologyFinder(mesh, field).find();
}

}  // namespace patchwright::cage
