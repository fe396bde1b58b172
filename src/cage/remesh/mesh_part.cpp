#include "cage/remesh/mesh_part.h"

#include <algorithm>

namespace patchwright::cage {

geom::SurfaceMesh part_of(const SurfaceBody& body, const std::vector<char>& kept) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    geom::SurfaceMesh part;
    std::vector<int> number(std::size_t(mesh.points.rows()), -1);
    std::vector<int> origin;
    for (const int t : body.triangles) {
        std::array<int, 3> corners = mesh.triangles[std::size_t(t)];
        for (int& v : corners) {
            int& n = number[std::size_t(v)];
            if (n < 0) {
                n = int(origin.size());
                origin.push_back(v);
                part.corners.push_back(mesh.corners[std::size_t(v)]);
            }
            v = n;
        }
        part.triangles.push_back(corners);
        part.faces.push_back(mesh.faces[std::size_t(t)]);
    }
    part.points.resize(Eigen::Index(origin.size()), 3);
    for (std::size_t i = 0; i < origin.size(); ++i)
        part.points.row(Eigen::Index(i)) = mesh.points.row(origin[i]);
    for (const geom::FeatureSide& f : mesh.features) {
        const auto side = std::minmax(number[std::size_t(f.v0)], number[std::size_t(f.v1)]);
        if (kept[std::size_t(f.curve)] == 0) continue;
        if (side.first >= 0) part.features.push_back({side.first, side.second, f.curve});
    }
    return part;
}

}  // namespace patchwright::cage
