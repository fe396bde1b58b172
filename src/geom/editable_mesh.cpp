#include "geom/editable_mesh.h"

#include "geom/angle.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace patchwright::geom {

using base::at;

namespace {

// Triangles with a smaller shape_quality() are needles, whose normals are not to be trusted: no
// collapse makes one worse. 0.08 is an angle of 5 degrees.
constexpr double needle_quality = 0.08;

int position(const std::array<int, 3>& t, int v) { return t[0] == v ? 0 : t[1] == v ? 1 : 2; }

bool holds(const std::array<int, 3>& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

}  // namespace

double shape_quality(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return longest > 0.0 ? (b - a).cross(c - a).norm() / longest : 0.0;
}

EditableMesh::EditableMesh(const SurfaceMesh& mesh)
    : triangles_(mesh.triangles), faces_(mesh.faces), corners_(mesh.corners) {
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) points_.push_back(mesh.points.row(i));
    fans_.resize(points_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (const int v : triangles_[t]) fans_[at(v)].push_back(int(t));
    curves_.assign(triangles_.size(), {-1, -1, -1});
    for (const FeatureSide& f : mesh.features) {
        const EdgeSides s = sides(f.v0, f.v1);
        for (std::size_t i = 0; i < 2; ++i)
            if (s.triangle[i] >= 0) curves_[at(s.triangle[i])][at(s.side[i])] = f.curve;
    }
}

std::vector<int> EditableMesh::neighbours(int v) const {
    // Sorted, as fans of a thousand triangles occur in what the kernel makes of cones and strips.
    std::vector<int> result;
    result.reserve(2 * fans_[at(v)].size());
    for (const int t : fans_[at(v)])
        for (const int w : triangles_[at(t)])
            if (w != v) result.push_back(w);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

std::vector<int> EditableMesh::feature_neighbours(int v) const {
    std::vector<int> result;
    const auto add = [&](int w) {
        if (std::find(result.begin(), result.end(), w) == result.end()) result.push_back(w);
    };
    for (const int t : fans_[at(v)]) {
        const auto& corners = triangles_[at(t)];
        const int k = position(corners, v);
        if (curve(t, k) >= 0) add(corners[at((k + 1) % 3)]);
        if (curve(t, (k + 2) % 3) >= 0) add(corners[at((k + 2) % 3)]);
    }
    return result;
}

VertexKind EditableMesh::kind(int v) const {
    const std::size_t count = feature_neighbours(v).size();
    if (corners_[at(v)] >= 0) return VertexKind::Fixed;
    return count == 0 ? VertexKind::Smooth : count == 2 ? VertexKind::Curve : VertexKind::Fixed;
}

int EditableMesh::curve_at(int v) const {
    for (const int t : fans_[at(v)]) {
        const int k = position(triangles_[at(t)], v);
        if (curve(t, k) >= 0) return curve(t, k);
        if (curve(t, (k + 2) % 3) >= 0) return curve(t, (k + 2) % 3);
    }
    return -1;
}

EdgeSides EditableMesh::sides(int a, int b) const {
    EdgeSides result;
    std::size_t found = 0;
    for (const int t : fans_[at(a)]) {
        const auto& corners = triangles_[at(t)];
        if (!holds(corners, b) || found == 2) continue;
        const int k = position(corners, a);
        result.triangle[found] = t;
        result.side[found] = corners[at((k + 1) % 3)] == b ? k : (k + 2) % 3;
        ++found;
    }
    return result;
}

bool EditableMesh::is_feature(int a, int b) const {
    const EdgeSides s = sides(a, b);
    return s.triangle[0] >= 0 && curve(s.triangle[0], s.side[0]) >= 0;
}

bool EditableMesh::is_boundary(int v) const {
    // Neighbours are met twice in a closed fan, the first and the last one of an open fan once.
    int odd = 0;
    for (const int t : fans_[at(v)])
        for (const int w : triangles_[at(t)])
            if (w != v) odd ^= w;
    return odd != 0;
}

int EditableMesh::corner_of(int t, int v) const { return position(triangles_[at(t)], v); }

double EditableMesh::corner_angle(int t, int k) const {
    const auto& c = triangles_[at(t)];
    const Vec3& p = points_[at(c[at(k)])];
    return angle_between(points_[at(c[at((k + 1) % 3)])] - p, points_[at(c[at((k + 2) % 3)])] - p);
}

Vec3 EditableMesh::area_vector(int t) const {
    const auto& [a, b, c] = triangles_[at(t)];
    return (points_[at(b)] - points_[at(a)]).cross(points_[at(c)] - points_[at(a)]);
}

Vec3 EditableMesh::vertex_normal(int v) const {
    Vec3 sum = Vec3::Zero();
    for (const int t : fans_[at(v)]) sum += area_vector(t);
    return sum.normalized();
}

bool EditableMesh::can_collapse(int gone, int kept) const {
    const EdgeSides s = sides(gone, kept);
    if (s.triangle[0] < 0) return false;
    const VertexKind kind_gone = kind(gone);
    if (kind_gone == VertexKind::Fixed) return false;
    if (kind_gone == VertexKind::Curve && curve(s.triangle[0], s.side[0]) < 0) return false;
    if (s.triangle[1] >= 0 && is_boundary(gone)) return false;
    for (std::size_t i = 0; i < 2; ++i) {
        const int t = s.triangle[i];
        if (t < 0) continue;
        const int other = triangles_[at(t)][at((s.side[i] + 2) % 3)];
        if (is_feature(gone, other) && is_feature(kept, other)) return false;
    }
    return stays_manifold(gone, kept);
}

bool EditableMesh::stays_manifold(int gone, int kept) const {
    const EdgeSides s = sides(gone, kept);
    if (s.triangle[0] < 0) return false;
    const bool boundary_edge = s.triangle[1] < 0;
    if (!boundary_edge && is_boundary(gone) && is_boundary(kept)) return false;
    // Link condition: only the triangles at the edge may join both ends.
    const auto of_gone = neighbours(gone), of_kept = neighbours(kept);
    int common = 0;
    for (const int w : of_gone)
        if (std::binary_search(of_kept.begin(), of_kept.end(), w)) ++common;
    if (common != (boundary_edge ? 1 : 2)) return false;
    for (std::size_t i = 0; i < 2; ++i) {
        const int t = s.triangle[i];
        if (t < 0) continue;
        const int other = triangles_[at(t)][at((s.side[i] + 2) % 3)];
        // The third corner must keep a proper fan.
        const std::size_t least = is_boundary(other) ? 2 : 4;
        if (fans_[at(other)].size() < least) return false;
    }
    return fans_[at(gone)].size() + fans_[at(kept)].size() > (boundary_edge ? 3u : 6u);
}

bool EditableMesh::collapse_is_flat(int gone, int kept, double least_cosine,
                                    double negligible) const {
    const EdgeSides s = sides(gone, kept);
    for (const int t : fans_[at(gone)]) {
        if (t == s.triangle[0] || t == s.triangle[1]) continue;
        std::array<Vec3, 3> p, old;
        for (std::size_t k = 0; k < 3; ++k) {
            const int v = triangles_[at(t)][k];
            old[k] = points_[at(v)];
            p[k] = points_[at(v == gone ? kept : v)];
        }
        if (std::max({(old[1] - old[0]).norm(), (old[2] - old[1]).norm(),
                      (old[0] - old[2]).norm()}) < negligible)
            continue;
        const Vec3 before = (old[1] - old[0]).cross(old[2] - old[0]);
        const Vec3 after = (p[1] - p[0]).cross(p[2] - p[0]);
        const double quality = shape_quality(p[0], p[1], p[2]);
        if (quality < needle_quality && quality < shape_quality(old[0], old[1], old[2]))
            return false;
        if (after.dot(before) <= least_cosine * after.norm() * before.norm()) return false;
    }
    return true;
}

void EditableMesh::detach(int v, int t) { std::erase(fans_[at(v)], t); }

void EditableMesh::replace(int t, int from, int to) {
    triangles_[at(t)][at(position(triangles_[at(t)], from))] = to;
    detach(from, t);
    fans_[at(to)].push_back(t);
}

void EditableMesh::collapse(int gone, int kept) {
    const EdgeSides s = sides(gone, kept);
    for (std::size_t i = 0; i < 2; ++i) {
        const int t = s.triangle[i];
        if (t < 0) continue;
        const int other = triangles_[at(t)][at((s.side[i] + 2) % 3)];
        // What was on the side that goes is on the side that it is merged with.
        const EdgeSides of_gone = sides(gone, other), of_kept = sides(kept, other);
        int label = curve(of_kept.triangle[0], of_kept.side[0]);
        if (label < 0) label = curve(of_gone.triangle[0], of_gone.side[0]);
        for (const EdgeSides& e : {of_gone, of_kept})
            for (std::size_t j = 0; j < 2; ++j)
                if (e.triangle[j] >= 0) curves_[at(e.triangle[j])][at(e.side[j])] = label;
    }
    for (const int t : s.triangle) {
        if (t < 0) continue;
        for (const int v : triangles_[at(t)]) detach(v, t);
        triangles_[at(t)] = {-1, -1, -1};
    }
    const std::vector<int> moved = fans_[at(gone)];
    for (const int t : moved) replace(t, gone, kept);
}

int EditableMesh::add_vertex(const Vec3& where) {
    points_.push_back(where);
    corners_.push_back(-1);
    fans_.emplace_back();
    return vertex_count() - 1;
}

int EditableMesh::split(int a, int b, const Vec3& where) {
    const EdgeSides s = sides(a, b);
    const int middle = add_vertex(where);
    for (std::size_t i = 0; i < 2; ++i) {
        const int t = s.triangle[i];
        if (t < 0) continue;
        const auto k = at(s.side[i]);
        // (from, to, other) becomes (from, middle, other) and (middle, to, other).
        const auto [from, to, other] = std::array<int, 3>{
            triangles_[at(t)][k], triangles_[at(t)][(k + 1) % 3], triangles_[at(t)][(k + 2) % 3]};
        const auto labels = std::array<int, 3>{curves_[at(t)][k], curves_[at(t)][(k + 1) % 3],
                                               curves_[at(t)][(k + 2) % 3]};
        const int made = triangle_count();
        triangles_[at(t)] = {from, middle, other};
        curves_[at(t)] = {labels[0], -1, labels[2]};
        triangles_.push_back({middle, to, other});
        curves_.push_back({labels[0], labels[1], -1});
        faces_.push_back(faces_[at(t)]);
        detach(to, t);
        fans_[at(middle)].push_back(t);
        for (const int v : {middle, to, other}) fans_[at(v)].push_back(made);
    }
    return middle;
}

bool EditableMesh::can_flip(int a, int b) const {
    const EdgeSides s = sides(a, b);
    if (s.triangle[1] < 0 || curve(s.triangle[0], s.side[0]) >= 0) return false;
    const int c = triangles_[at(s.triangle[0])][at((s.side[0] + 2) % 3)];
    const int d = triangles_[at(s.triangle[1])][at((s.side[1] + 2) % 3)];
    if (c == d || sides(c, d).triangle[0] >= 0) return false;
    return fans_[at(a)].size() > (is_boundary(a) ? 1u : 3u) &&
           fans_[at(b)].size() > (is_boundary(b) ? 1u : 3u);
}

void EditableMesh::flip(int a, int b) {
    const EdgeSides s = sides(a, b);
    const int t = s.triangle[0], u = s.triangle[1];
    const auto k = at(s.side[0]), l = at(s.side[1]);
    const auto ft = triangles_[at(t)], fu = triangles_[at(u)];
    const auto lt = curves_[at(t)], lu = curves_[at(u)];
    const int from = ft[k], to = ft[(k + 1) % 3], c = ft[(k + 2) % 3], d = fu[(l + 2) % 3];
    // t = (from, to, c), u = (to, from, d) become (c, from, d) and (d, to, c).
    triangles_[at(t)] = {c, from, d};
    curves_[at(t)] = {lt[(k + 2) % 3], lu[(l + 1) % 3], -1};
    triangles_[at(u)] = {d, to, c};
    curves_[at(u)] = {lu[(l + 2) % 3], lt[(k + 1) % 3], -1};
    detach(to, t);
    detach(from, u);
    fans_[at(d)].push_back(t);
    fans_[at(c)].push_back(u);
}

}  // namespace patchwright::geom
