#include "occ/foot/beside_foot.h"

namespace patchwright::occ {

using geom::Vec3;

namespace {

bool in_box(const FaceSurface::Rectangle& box, const Vec2& uv) {
    return (uv.array() >= box.low.array()).all() && (uv.array() <= box.high.array()).all();
}

bool in_triangle(const std::array<Vec2, 3>& corner, const Vec2& uv) {
    const auto side = [&](std::size_t i, std::size_t j) {
        const Vec2 along = corner[j] - corner[i], to = uv - corner[i];
        return along[0] * to[1] - along[1] * to[0];
    };
    const double a = side(0, 1), b = side(1, 2), c = side(2, 0);
    return (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
}

bool bends_little(const Vec3& query, const SurfaceFoot& f, const Surroundings& here) {
    const std::size_t way = (query - f.foot.point).dot(f.foot.normal) > 0.0 ? 0 : 1;
    return f.foot.distance * double(here.bend[way]) < convex_share;
}

// Triangles of one face that share a node.
bool are_neighbours(const ReferenceMesh& mesh, int slot, int other) {
    const auto a = std::size_t(slot), b = std::size_t(other);
    if (mesh.starts[a].face != mesh.starts[b].face) return false;
    bool shared = false;
    for (const auto i : mesh.around[a].node)
        for (const auto j : mesh.around[b].node) shared |= i == j;
    return shared;
}

}  // namespace

bool is_clear_of_trim(const ReferenceMesh& mesh, const SurfaceFoot& f) {
    const auto slot = std::size_t(f.slot);
    return mesh.around[slot].clearance > 0.0f && in_triangle(mesh.starts[slot].uv, f.foot.uv);
}

bool holds_none_nearer_than(const ReferenceMesh& mesh, const Vec3& query, const SurfaceFoot& f,
                            int slot) {
    if (is_held(f)) return false;
    // Where the foot lies off the triangle that led to it, both rings tell.
    const FaceSurface::Rectangle box = box_of(mesh.starts[std::size_t(f.slot)].uv);
    const Vec2 margin = 0.5 * (box.high - box.low);
    if (!in_box({box.low - margin, box.high + margin}, f.foot.uv)) return false;
    if (!are_neighbours(mesh, f.slot, slot)) return false;
    return bends_little(query, f, mesh.around[std::size_t(f.slot)]) &&
           (in_box(box, f.foot.uv) || bends_little(query, f, mesh.around[std::size_t(slot)]));
}

bool is_alone(const ReferenceMesh& mesh, const Vec3& query, const SurfaceFoot& f,
              const std::vector<PassedLeaf>& passed, double limit) {
    const Surroundings& around = mesh.around[std::size_t(f.slot)];
    if (!mesh.covers_edges || is_held(f) || !around.tight) return false;
    if (!in_box(box_of(mesh.starts[std::size_t(f.slot)].uv), f.foot.uv)) return false;
    if (!bends_little(query, f, around)) return false;
    // Bounds were rounded to single precision.
    const auto most = float(limit * (1.0 + 1e-6));
    for (const PassedLeaf& leaf : passed) {
        for (std::size_t i = 0; i < leaf.lower.size(); ++i) {
            const int slot = leaf.slot + int(i);
            if (leaf.lower[i] <= most && slot != f.slot && !are_neighbours(mesh, f.slot, slot))
                return false;
        }
    }
    return true;
}

}  // namespace patchwright::occ
