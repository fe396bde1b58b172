#include "cage/remesh/quads.h"

#include "cage/remesh/border_rows.h"
#include "cage/remesh/even_regions.h"
#include "cage/remesh/merge_triangles.h"
#include "cage/remesh/quad_shape.h"
#include "cage/remesh/relax_quads.h"
#include "cage/remesh/sectors.h"
#include "cage/remesh/tidy_quads.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Of merging, tidying and relaxing, until nothing changes, at most.
constexpr int tidying_rounds = 4;

struct Pair {
    double quality;
    int first, second;
    std::array<int, 4> corners;
    int a, b;  ///< ends of the diagonal that goes
};

std::vector<Pair> candidates(const geom::EditableMesh& mesh) {
    std::vector<Pair> pairs;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.alive(t)) continue;
        for (int k = 0; k < 3; ++k) {
            const auto& c = mesh.triangle(t);
            const int a = c[std::size_t(k)], b = c[std::size_t((k + 1) % 3)];
            if (mesh.curve(t, k) >= 0) continue;
            const geom::EdgeSides s = mesh.sides(a, b);
            if (s.triangle[1] < 0 || std::min(s.triangle[0], s.triangle[1]) != t) continue;
            const std::size_t i = s.triangle[0] == t ? 1 : 0;
            const int other = s.triangle[i];
            const int d = mesh.triangle(other)[std::size_t((s.side[i] + 2) % 3)];
            const std::array<int, 4> corners{a, d, b, c[std::size_t((k + 2) % 3)]};
            const double quality = quad_quality({mesh.point(corners[0]), mesh.point(corners[1]),
                                                 mesh.point(corners[2]), mesh.point(corners[3])});
            if (quality > least_quad_quality) pairs.push_back({quality, t, other, corners, a, b});
        }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& x, const Pair& y) { return x.quality > y.quality; });
    return pairs;
}

Polygons pair_triangles(const geom::EditableMesh& mesh) {
    Sectors sectors = sectors_of(mesh);
    std::vector<int> count(std::size_t(mesh.vertex_count()), 0);
    for (int v = 0; v < mesh.vertex_count(); ++v) count[std::size_t(v)] = int(mesh.fan(v).size());
    std::vector<char> used(std::size_t(mesh.triangle_count()), 0);
    const auto sector_at = [&](int t, int v) -> FaceSector& {
        const int k = mesh.corner_of(t, v);
        return sectors.sectors[std::size_t(sectors.of_corner[std::size_t(t)][std::size_t(k)])];
    };
    const auto can_lose = [&](const Pair& pair, int v) {
        const FaceSector& sector = sector_at(pair.first, v);
        const double angle = mesh.corner_angle(pair.first, mesh.corner_of(pair.first, v)) +
                             mesh.corner_angle(pair.second, mesh.corner_of(pair.second, v));
        return is_even_enough(mesh.kind(v), angle, sector.angle_rad) &&
               sector.faces > sector.least && count[std::size_t(v)] > (mesh.is_boundary(v) ? 1 : 3);
    };
    Polygons polygons;
    for (const Pair& pair : candidates(mesh)) {
        if (used[std::size_t(pair.first)] != 0 || used[std::size_t(pair.second)] != 0) continue;
        if (!can_lose(pair, pair.a) || !can_lose(pair, pair.b)) continue;
        used[std::size_t(pair.first)] = used[std::size_t(pair.second)] = 1;
        for (const int v : {pair.a, pair.b}) {
            --sector_at(pair.first, v).faces;
            --count[std::size_t(v)];
        }
        polygons.corners.emplace_back(pair.corners.begin(), pair.corners.end());
        polygons.faces.push_back(mesh.face(pair.first));
    }
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.alive(t) || used[std::size_t(t)] != 0) continue;
        const auto& c = mesh.triangle(t);
        polygons.corners.push_back({c[0], c[1], c[2]});
        polygons.faces.push_back(mesh.face(t));
    }
    return polygons;
}

/// Into two triangles, along the diagonal that leaves the larger angles and is no edge already.
void split_bad_quads(PolygonMesh& polygons) {
    const int count = polygons.count();
    for (int i = 0; i < count; ++i) {
        const std::vector<int> c = polygons.corners(i);
        if (c.size() != 4 || polygons.quality(i) > least_quad_quality) continue;
        const auto p = [&](std::size_t k) { return polygons.mesh().point(c[k]); };
        const auto least = [&](std::size_t k) {
            if (!polygons.of_edge(c[k], c[k + 2]).empty()) return -1.0;
            return std::min(triangle_quality({p(k), p(k + 1), p(k + 2)}),
                            triangle_quality({p(k), p(k + 2), p((k + 3) % 4)}));
        };
        const std::size_t from = least(0) > least(1) ? 0 : 1;
        if (least(from) < 0.0) continue;
        polygons.replace(i, {c[from], c[from + 1], c[from + 2]});
        polygons.add({c[from + 2], c[(from + 3) % 4], c[from]}, i);
    }
}

}  // namespace

Blocks quad_blocks(geom::EditableMesh& mesh, const geom::ModelSurface& reference,
                   const std::vector<std::string>& face_names, Poll& poll) {
    PolygonMesh edited(pair_triangles(mesh), mesh);
    merge_triangles(edited, poll);
    make_regions_even(edited, reference, poll);
    merge_triangles(edited, poll);
    QuadRelaxation relaxation(edited, reference, poll);
    relaxation.run();
    if (add_border_rows(edited)) relaxation.run();
    for (int round = 0; round < tidying_rounds; ++round) {
        const bool merged = merge_triangles(edited, poll);
        if (!tidy_quads(edited, poll) && !merged) break;
        relaxation.run();
    }
    split_bad_quads(edited);
    Polygons polygons = edited.polygons();
    Blocks blocks;
    std::vector<int> number(std::size_t(mesh.vertex_count()), -1);
    for (std::size_t i = 0; i < polygons.corners.size(); ++i) {
        blocks.groups.push_back(face_names[std::size_t(polygons.faces[i])]);
        for (int& v : polygons.corners[i]) {
            int& n = number[std::size_t(v)];
            if (n < 0) {
                n = int(blocks.points.size());
                blocks.points.push_back(mesh.point(v));
                // A crease may end in a smooth surface; three and more make a corner by themselves.
                if (mesh.corner(v) >= 0 && mesh.feature_neighbours(v).size() != 1)
                    blocks.corners.push_back(n);
            }
            v = n;
        }
    }
    blocks.faces = std::move(polygons.corners);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.alive(t)) continue;
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangle(t)[std::size_t(k)];
            const int b = mesh.triangle(t)[std::size_t((k + 1) % 3)];
            const int curve = mesh.curve(t, k);
            if (curve < 0 || mesh.sides(a, b).triangle[1] < 0 || a > b) continue;
            if (reference.features().curves[std::size_t(curve)].kind == geom::FeatureKind::Sharp)
                blocks.creases.emplace_back(number[std::size_t(a)], number[std::size_t(b)]);
        }
    }
    return blocks;
}

}  // namespace patchwright::cage
