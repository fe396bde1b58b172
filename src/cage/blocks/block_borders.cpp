#include "cage/blocks/block_borders.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// How far from a smooth curve the curvatures on both sides are taken, of the diagonal. They jump
// when they differ by this share of the larger one; that must turn by a radian over the diagonal at
// least, as what is almost flat jumps by noise.
constexpr double jump_step_rel = 2e-3, least_change = 0.5, least_bend = 1.0;

/// The triangles of all edges.
class EdgeTriangles {
  public:
    explicit EdgeTriangles(const geom::SurfaceMesh& mesh) : mesh_(mesh) {
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                triangles_[std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3])]
                    .push_back(int(t));
    }
    [[nodiscard]] const std::vector<int>& of(int a, int b) const {
        return triangles_.at(std::minmax(a, b));
    }
    [[nodiscard]] const std::map<std::pair<int, int>, std::vector<int>>& all() const {
        return triangles_;
    }

  private:
    const geom::SurfaceMesh& mesh_;
    std::map<std::pair<int, int>, std::vector<int>> triangles_;
};

Vec3 point_of(const geom::SurfaceMesh& mesh, int v) { return mesh.points.row(v).transpose(); }

/// Whether the curvature across a side of a smooth feature is another one on the other side.
bool curvature_jumps(const geom::SurfaceMesh& mesh, const EdgeTriangles& sides,
                     const geom::ModelSurface& reference, const geom::FeatureSide& side) {
    const double diagonal = reference.size();
    const Vec3 a = point_of(mesh, side.v0), b = point_of(mesh, side.v1);
    const Vec3 middle = 0.5 * (a + b), along = (b - a).normalized();
    std::vector<double> across;
    for (const int t : sides.of(side.v0, side.v1)) {
        const auto& c = mesh.triangles[at(t)];
        const Vec3 p = point_of(mesh, c[0]), q = point_of(mesh, c[1]), r = point_of(mesh, c[2]);
        const Vec3 inward = (p + q + r) / 3.0 - middle;
        const double step =
            std::min(1.0, jump_step_rel * diagonal / std::max(inward.norm(), 1e-300));
        const Vec3 normal = (q - p).cross(r - p).normalized();
        if (!normal.allFinite()) return false;
        const auto bend = reference.curvature(reference.foot_point(middle + step * inward, normal));
        if (!bend) return false;
        double sum = 0.0;
        for (std::size_t j = 0; j < 2; ++j) {
            const double cosine = bend->direction[j].dot(along);
            sum += bend->value[j] * (1.0 - cosine * cosine);
        }
        across.push_back(sum);
    }
    if (across.size() != 2) return false;
    const double most = std::max(std::abs(across[0]), std::abs(across[1]));
    return most * diagonal > least_bend && std::abs(across[0] - across[1]) > least_change * most;
}

/// Adds smooth curves where the curvature jumps.
void keep_jumps(const geom::SurfaceMesh& mesh, const EdgeTriangles& sides,
                const geom::ModelSurface& reference, std::vector<char>& kept, Poll& poll) {
    std::vector<int> jumps(kept.size(), 0), total(kept.size(), 0);
    for (const geom::FeatureSide& side : mesh.features) {
        poll();
        if (kept[at(side.curve)] != 0) continue;
        const auto& both = sides.of(side.v0, side.v1);
        ++total[at(side.curve)];
        if (both.size() != 2 || mesh.faces[at(both[0])] == mesh.faces[at(both[1])]) continue;
        if (curvature_jumps(mesh, sides, reference, side)) ++jumps[at(side.curve)];
    }
    for (std::size_t i = 0; i < kept.size(); ++i)
        if (2 * jumps[i] > total[i]) kept[i] = 1;
}

/// Regions with handles, as tori are, keep the seams of their faces.
void keep_seams(const geom::SurfaceMesh& mesh, const EdgeTriangles& sides,
                std::vector<char>& kept) {
    std::set<std::pair<int, int>> walls;
    for (const geom::FeatureSide& f : mesh.features)
        if (kept[at(f.curve)] != 0) walls.insert({f.v0, f.v1});
    std::vector<int> region(mesh.triangles.size(), -1);
    for (std::size_t seed = 0; seed < region.size(); ++seed) {
        if (region[seed] >= 0) continue;
        std::vector<int> pending{int(seed)};
        region[seed] = int(seed);
        std::set<int> vertices;
        std::set<std::pair<int, int>> edges;
        std::map<int, std::vector<int>> border;
        for (std::size_t i = 0; i < pending.size(); ++i) {
            const auto& c = mesh.triangles[at(pending[i])];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::pair<int, int> edge = std::minmax(c[k], c[(k + 1) % 3]);
                vertices.insert(c[k]);
                edges.insert(edge);
                const auto& both = sides.of(edge.first, edge.second);
                if (walls.contains(edge) || both.size() != 2) {
                    border[edge.first].push_back(edge.second);
                    border[edge.second].push_back(edge.first);
                    continue;
                }
                for (const int t : both) {
                    if (region[at(t)] >= 0) continue;
                    region[at(t)] = int(seed);
                    pending.push_back(t);
                }
            }
        }
        int borders = 0;
        std::set<int> seen;
        for (const auto& [start, others] : border) {
            if (!seen.insert(start).second) continue;
            ++borders;
            std::vector<int> line{start};
            for (std::size_t i = 0; i < line.size(); ++i)
                for (const int w : border[line[i]])
                    if (seen.insert(w).second) line.push_back(w);
        }
        const int euler = int(vertices.size()) - int(edges.size()) + int(pending.size());
        if (euler + borders == 2) continue;
        for (const geom::FeatureSide& f : mesh.features)
            if (edges.contains({f.v0, f.v1})) kept[at(f.curve)] = 1;
    }
}

}  // namespace

std::vector<char> block_borders(const geom::SurfaceMesh& surface,
                                const geom::ModelSurface& reference, const std::vector<char>& kept,
                                Poll& poll) {
    const EdgeTriangles sides(surface);
    std::vector<char> borders = kept;
    keep_jumps(surface, sides, reference, borders, poll);
    keep_seams(surface, sides, borders);
    return borders;
}

}  // namespace patchwright::cage
