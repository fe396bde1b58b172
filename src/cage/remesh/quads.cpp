#include "cage/remesh/quads.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Below this a pair is worse than two triangles: an angle above 166 degrees, or a fold.
constexpr double least_quality = 0.15;
// Cosine of the angle by which a quad may bend: 60 degrees.
constexpr double most_bent_cosine = 0.5;
// The widest corner of one face, 150 degrees: a sector that is wider needs two faces.
constexpr double widest_corner_rad = 2.6;
// The widest sector of two faces, 210 degrees. The surface at a corner between sharp edges d1, d2
// with one edge e between them follows, after k steps, e + k (d1 + d2) / 6: in a wider sector that
// turns over the sharp edges within a thousandth of e.
constexpr double widest_pair_rad = 3.67;

/// 1 for flat rectangles, 0 when an angle is 0 or 180 degrees or the quad bends by 60.
double quad_quality(const std::array<Vec3, 4>& p) {
    const Vec3 one = (p[1] - p[0]).cross(p[2] - p[0]), two = (p[2] - p[0]).cross(p[3] - p[0]);
    const Vec3 other = (p[2] - p[1]).cross(p[3] - p[1]), fourth = (p[3] - p[1]).cross(p[0] - p[1]);
    const auto cosine = [](const Vec3& a, const Vec3& b) {
        const double norm = a.norm() * b.norm();
        return norm > 0.0 ? a.dot(b) / norm : -1.0;
    };
    const double flat = std::min(cosine(one, two), cosine(other, fourth));
    if (flat < most_bent_cosine) return 0.0;
    const Vec3 normal = (one + two).normalized();
    double worst = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 a = p[(k + 1) % 4] - p[k], b = p[(k + 3) % 4] - p[k];
        double angle = std::atan2(normal.dot(a.cross(b)), a.dot(b));
        if (angle < 0.0) angle += 2.0 * M_PI;
        worst = std::max(worst, std::abs(angle - 0.5 * M_PI));
    }
    return std::max(0.0, 1.0 - worst / (0.5 * M_PI)) * (flat - most_bent_cosine) /
           (1.0 - most_bent_cosine);
}

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
            if (quality > least_quality) pairs.push_back({quality, t, other, corners, a, b});
        }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& x, const Pair& y) { return x.quality > y.quality; });
    return pairs;
}

/// The triangles at a vertex between two features, or all of them.
struct FaceSector {
    int faces = 0;  ///< as pairing goes on
    int least = 1;  ///< with fewer the surface has no proper tangent plane there
};

/// The sectors of all vertices, and which one each corner of a triangle is in.
struct Sectors {
    std::vector<FaceSector> sectors;
    std::vector<std::array<int, 3>> of_corner;
};

void add_sectors(const geom::EditableMesh& mesh, int v, Sectors& result) {
    const geom::VertexKind kind = mesh.kind(v);
    const auto& fan = mesh.fan(v);
    for (const int first : fan) {
        if (result.of_corner[std::size_t(first)][std::size_t(mesh.corner_of(first, v))] >= 0)
            continue;
        const int number = int(result.sectors.size());
        FaceSector sector;
        double angle = 0.0;
        std::vector<int> pending{first};
        while (!pending.empty()) {
            const int t = pending.back();
            pending.pop_back();
            const int k = mesh.corner_of(t, v);
            int& mine = result.of_corner[std::size_t(t)][std::size_t(k)];
            if (mine >= 0) continue;
            mine = number;
            ++sector.faces;
            angle += mesh.corner_angle(t, k);
            for (const int side : {k, (k + 2) % 3}) {
                if (mesh.curve(t, side) >= 0) continue;
                const auto& c = mesh.triangle(t);
                const int other = c[std::size_t(side == k ? (k + 1) % 3 : (k + 2) % 3)];
                for (const int neighbour : mesh.sides(v, other).triangle)
                    if (neighbour >= 0) pending.push_back(neighbour);
            }
        }
        // Along a smooth curve the sector is half a disc however its chords turn.
        sector.least = kind == geom::VertexKind::Smooth  ? (mesh.is_boundary(v) ? 1 : 3)
                       : kind == geom::VertexKind::Curve ? 2
                       : angle > widest_pair_rad         ? 3
                       : angle > widest_corner_rad       ? 2
                                                         : 1;
        result.sectors.push_back(sector);
    }
}

Sectors sectors_of(const geom::EditableMesh& mesh) {
    Sectors result;
    result.of_corner.assign(std::size_t(mesh.triangle_count()), {-1, -1, -1});
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertex_alive(v)) add_sectors(mesh, v, result);
    return result;
}

struct Polygons {
    std::vector<std::vector<int>> corners;
    std::vector<int> faces;  ///< of the model
};

Polygons pair_triangles(const geom::EditableMesh& mesh) {
    Sectors sectors = sectors_of(mesh);
    std::vector<int> count(std::size_t(mesh.vertex_count()), 0);
    for (int v = 0; v < mesh.vertex_count(); ++v) count[std::size_t(v)] = int(mesh.fan(v).size());
    std::vector<char> used(std::size_t(mesh.triangle_count()), 0);
    const auto sector_at = [&](int t, int v) -> FaceSector& {
        const int k = mesh.corner_of(t, v);
        return sectors.sectors[std::size_t(sectors.of_corner[std::size_t(t)][std::size_t(k)])];
    };
    const auto can_lose = [&](int t, int v) {
        const FaceSector& sector = sector_at(t, v);
        return sector.faces > sector.least && count[std::size_t(v)] > (mesh.is_boundary(v) ? 1 : 3);
    };
    Polygons polygons;
    for (const Pair& pair : candidates(mesh)) {
        if (used[std::size_t(pair.first)] != 0 || used[std::size_t(pair.second)] != 0) continue;
        if (!can_lose(pair.first, pair.a) || !can_lose(pair.first, pair.b)) continue;
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

}  // namespace

Blocks quad_blocks(const geom::EditableMesh& mesh, const geom::Features& features,
                   const std::vector<std::string>& face_names) {
    Polygons polygons = pair_triangles(mesh);
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
            if (features.curves[std::size_t(curve)].kind == geom::FeatureKind::Sharp)
                blocks.creases.emplace_back(number[std::size_t(a)], number[std::size_t(b)]);
        }
    }
    return blocks;
}

}  // namespace patchwright::cage
