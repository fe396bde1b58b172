#include "cage/remesh/sectors.h"

#include "cage/remesh/quad_shape.h"

namespace patchwright::cage {

namespace {

void add_sectors(const geom::EditableMesh& mesh, int v, Sectors& result) {
    const auto& fan = mesh.fan(v);
    for (const int first : fan) {
        if (result.of_corner[std::size_t(first)][std::size_t(mesh.corner_of(first, v))] >= 0)
            continue;
        const int number = int(result.sectors.size());
        FaceSector sector;
        std::vector<int> pending{first};
        while (!pending.empty()) {
            const int t = pending.back();
            pending.pop_back();
            const int k = mesh.corner_of(t, v);
            int& mine = result.of_corner[std::size_t(t)][std::size_t(k)];
            if (mine >= 0) continue;
            mine = number;
            ++sector.faces;
            sector.angle_rad += mesh.corner_angle(t, k);
            for (const int side : {k, (k + 2) % 3}) {
                if (mesh.curve(t, side) >= 0) continue;
                const auto& c = mesh.triangle(t);
                const int other = c[std::size_t(side == k ? (k + 1) % 3 : (k + 2) % 3)];
                for (const int neighbour : mesh.sides(v, other).triangle)
                    if (neighbour >= 0) pending.push_back(neighbour);
            }
        }
        sector.least = least_faces(mesh.kind(v), mesh.is_boundary(v), sector.angle_rad);
        result.sectors.push_back(sector);
    }
}

}  // namespace

Sectors sectors_of(const geom::EditableMesh& mesh) {
    Sectors result;
    result.of_corner.assign(std::size_t(mesh.triangle_count()), {-1, -1, -1});
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertex_alive(v)) add_sectors(mesh, v, result);
    return result;
}

}  // namespace patchwright::cage
