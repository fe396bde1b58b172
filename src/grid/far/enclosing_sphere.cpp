#include "grid/far/enclosing_sphere.h"

#include "geom/disjoint_sets.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::grid {

namespace {

using geom::Vec3;

/// A sphere encloses the surface in one layer of blocks, or half a sphere what is on one side of a
/// plane.
void check_topology(const Plan& plan, const FrontMesh& mesh) {
    const auto cells = mesh.cells(plan);
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
    geom::DisjointSets bodies(mesh.size());
    for (const auto& cell : cells) {
        for (std::size_t k = 0; k < 4; ++k) {
            edges.push_back(std::minmax(cell[k], cell[(k + 1) % 4]));
            bodies.join(edges.back().first, edges.back().second);
        }
    }
    std::sort(edges.begin(), edges.end());
    std::size_t uses = 0, body_count = 0;
    const Vec3* plane = nullptr;
    bool is_in_plane = true;
    std::int64_t euler = std::int64_t(mesh.size()) + std::int64_t(cells.size());
    for (std::size_t n = 0; n < edges.size(); n += uses) {
        for (uses = 1; n + uses < edges.size() && edges[n + uses] == edges[n];) ++uses;
        --euler;
        if (uses > 1) continue;
        const Vec3& here = mesh.plane(std::size_t(edges[n].first));
        if (plane == nullptr) plane = &here;
        is_in_plane = is_in_plane && !here.isZero(0.0) && here == *plane;
    }
    for (std::size_t p = 0; p < mesh.size(); ++p) body_count += bodies.find(int(p)) == int(p);
    const auto refuse = [](const std::string& what) {
        throw base::UsageError(
            "a far field with one block over each of the surface's needs one closed body without "
            "handles, or one that ends along one line in one plane; this surface " +
            what);
    };
    if (body_count != 1) refuse(fmt::format("has {} bodies", body_count));
    if (!is_in_plane) refuse("ends elsewhere than along one line in one plane across it");
    if (plane != nullptr && euler != 1) refuse("has handles, or ends along several lines");
    if (plane == nullptr && euler != 2)
        refuse(euler == 0 ? "has a handle" : fmt::format("has {} handles", (2 - euler) / 2));
}

}  // namespace

Sphere enclosing_sphere(const Plan& plan, const FrontMesh& mesh, double radius_mm) {
    check_topology(plan, mesh);
    Sphere sphere{geom::bounding_box(mesh.surface()).centre(), radius_mm};
    for (std::size_t p = 0; p < mesh.size(); ++p) {
        const Vec3& plane = mesh.plane(p);
        if (plane.isZero(0.0)) continue;
        sphere.centre +=
            plane * plane.dot(mesh.surface().row(Eigen::Index(p)).transpose() - sphere.centre);
        break;
    }
    return sphere;
}

}  // namespace patchwright::grid
