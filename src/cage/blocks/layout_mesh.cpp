#include "cage/blocks/layout_mesh.h"

#include "cage/blocks/close_strips.h"
#include "cage/remesh/mesh_part.h"
#include "cage/remesh/remesh.h"

#include <patchwright/base/numbers.h>

#include <array>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Longest triangle of the diagonal, and length of triangles by that of edges of a remeshed cage.
constexpr double longest_triangle_rel = 0.06, triangle_scale = 0.5;

/// Gives features that are one side long some vertices.
void divide_short_features(geom::EditableMesh& mesh, const geom::ModelSurface& reference) {
    // Of the first and last side of a feature: then it has room for three splits.
    constexpr int halvings = 2;
    for (int round = 0; round < halvings; ++round) {
        std::vector<std::array<int, 3>> sides;
        for (int t = 0; t < mesh.triangle_count(); ++t) {
            if (!mesh.alive(t)) continue;
            for (int k = 0; k < 3; ++k) {
                const auto& c = mesh.triangle(t);
                const int a = c[at(k)], b = c[at((k + 1) % 3)];
                const int curve = mesh.curve(t, k);
                if (curve < 0) continue;
                const auto& s = mesh.sides(a, b);
                if (s.triangle[1] >= 0 && a > b) continue;
                const bool end = mesh.kind(a) == geom::VertexKind::Fixed ||
                                 mesh.kind(b) == geom::VertexKind::Fixed;
                if (end) sides.push_back({a, b, curve});
            }
        }
        for (const auto& [a, b, curve] : sides) {
            const Vec3 middle = 0.5 * (mesh.point(a) + mesh.point(b));
            mesh.split(a, b, reference.nearest_on_curve(curve, middle).point);
        }
    }
}

}  // namespace

geom::EditableMesh layout_mesh(const SurfaceBody& body, const std::vector<char>& borders,
                               double tolerance_rel, const geom::ModelSurface& reference,
                               Poll& poll, int& closed_strips) {
    geom::EditableMesh mesh(part_of(body, borders));
    closed_strips =
        close_strips(mesh, reference, closed_share * tolerance_rel * reference.size(), poll);
    RemeshOptions remeshing;
    remeshing.size.tolerance_rel = tolerance_rel;
    remeshing.size.largest_rel = longest_triangle_rel / triangle_scale;
    remeshing.size.scale = triangle_scale;
    remesh(mesh, reference, remeshing, poll);
    divide_short_features(mesh, reference);
    return mesh;
}

}  // namespace patchwright::cage
