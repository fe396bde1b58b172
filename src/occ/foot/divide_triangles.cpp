#include "occ/foot/divide_triangles.h"

#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace patchwright::occ {

using geom::Vec3;

namespace {

/// Of what was asked for: the kernel keeps to that but for a small factor where nothing is wrong.
constexpr double coarse = 4.0;
/// Halvings of a triangle's sides, each of which leaves a quarter of the distance.
constexpr int most_halvings = 4;

/// Halvings after which the triangle is as near to its face as was asked for.
int halvings_of(const MeshTriangle& t, const FaceSurface& surface, double deflection) {
    double off = 0.0;
    for (const Vec3& w : {Vec3(0.5, 0.5, 0.0), Vec3(0.0, 0.5, 0.5), Vec3(0.5, 0.0, 0.5),
                          Vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)}) {
        const Vec2 uv = w[0] * t.uv[0] + w[1] * t.uv[1] + w[2] * t.uv[2];
        const Vec3 p = surface.at(uv), near = geom::nearest_weights(p, t.corner);
        const auto& [a, b, c] = t.corner;
        off = std::max(off, (near[0] * a + near[1] * b + near[2] * c - p).norm());
    }
    if (!(off > coarse * std::max(deflection, t.sickle))) return 0;
    const double wanted = std::ceil(0.5 * std::log2(off / deflection));
    return int(std::min(wanted, double(most_halvings)));
}

/// Divides the triangles of one face.
class FaceDivision {
  public:
    FaceDivision(const FaceSurface& surface, int& nodes, std::vector<MeshTriangle>& into)
        : surface_(surface), nodes_(nodes), into_(into) {}

    void add(const MeshTriangle& t, int halvings) {
        if (halvings == 0) {
            into_.push_back(t);
            return;
        }
        std::array<Vec2, 3> uv;
        std::array<Vec3, 3> corner;
        std::array<int, 3> node{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t next = (k + 1) % 3;
            uv[k] = 0.5 * (t.uv[k] + t.uv[next]);
            corner[k] = surface_.at(uv[k]);
            const auto [it, is_new] =
                middles_.try_emplace(std::minmax(t.node[k], t.node[next]), nodes_);
            if (is_new) ++nodes_;
            node[k] = it->second;
        }
        // The sickle may lie beside any of the parts.
        MeshTriangle part = t;
        part.uv = uv;
        part.corner = corner;
        part.node = node;
        add(part, halvings - 1);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t before = (k + 2) % 3;
            part.uv = {t.uv[k], uv[k], uv[before]};
            part.corner = {t.corner[k], corner[k], corner[before]};
            part.node = {t.node[k], node[k], node[before]};
            add(part, halvings - 1);
        }
    }

  private:
    const FaceSurface& surface_;
    int& nodes_;
    std::vector<MeshTriangle>& into_;
    std::map<std::pair<int, int>, int> middles_;  ///< nodes, by those at both ends of a side
};

}  // namespace

void divide_coarse_triangles(ReferenceMesh& mesh, const std::vector<FaceSurface>& surfaces,
                             double deflection) {
    std::vector<int> halvings(mesh.triangles.size());
    base::parallel_for(halvings.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const MeshTriangle& t = mesh.triangles[i];
            halvings[i] = halvings_of(t, surfaces[std::size_t(t.face)], deflection);
        }
    });
    if (std::all_of(halvings.begin(), halvings.end(), [](int n) { return n == 0; })) return;
    std::vector<MeshTriangle> triangles;
    for (std::size_t face = 0; face + 1 < mesh.first.size(); ++face) {
        const std::size_t begin = mesh.first[face], end = mesh.first[face + 1];
        mesh.first[face] = triangles.size();
        FaceDivision division(surfaces[face], mesh.nodes, triangles);
        for (std::size_t i = begin; i < end; ++i) division.add(mesh.triangles[i], halvings[i]);
    }
    mesh.first.back() = triangles.size();
    mesh.triangles = std::move(triangles);
}

}  // namespace patchwright::occ
