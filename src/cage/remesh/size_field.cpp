#include "cage/remesh/size_field.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <queue>

namespace patchwright::cage {

using geom::Vec3;

namespace {

/// Of the surface on all sides of a vertex: feet are taken a little inside each triangle, as at a
/// sharp edge the nearest point is on one face only.
double surface_curvature(const TriMesh& mesh, const geom::ModelSurface& reference, int v) {
    double largest = 0.0;
    for (const int t : mesh.fan(v)) {
        const auto& c = mesh.triangle(t);
        const Vec3 middle = (mesh.point(c[0]) + mesh.point(c[1]) + mesh.point(c[2])) / 3.0;
        const Vec3 normal = mesh.area_vector(t).normalized();
        if (!normal.allFinite()) continue;
        const geom::FootPoint foot =
            reference.foot_point(0.9 * mesh.point(v) + 0.1 * middle, normal);
        const auto curvature = reference.curvature(foot);
        if (!curvature) continue;
        largest = std::max({largest, std::abs(curvature->value[0]), std::abs(curvature->value[1])});
    }
    return largest;
}

double curve_curvature(const TriMesh& mesh, int v) {
    if (mesh.kind(v) != VertexKind::Curve) return 0.0;
    const auto next = mesh.feature_neighbours(v);
    const Vec3 a = mesh.point(v) - mesh.point(next[0]), b = mesh.point(next[1]) - mesh.point(v);
    const double length = 0.5 * (a.norm() + b.norm());
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    return length > 0.0 ? angle / length : 0.0;
}

}  // namespace

SizeField::SizeField(const TriMesh& mesh, const geom::ModelSurface& reference,
                     const SizeOptions& options)
    : mesh_(mesh),
      reference_(reference),
      options_(options),
      size_(std::size_t(mesh.vertex_count()), 0.0) {
    base::parallel_for(size_.size(), 64, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            if (mesh_.vertex_alive(int(i))) size_[i] = at_places(int(i)) * by_curvature(int(i));
    });
    limit_growth();
    for (double& s : size_) s *= options.scale;
}

double SizeField::by_curvature(int v) const {
    const double diagonal = reference_.bounds().diagonal();
    double size = options_.largest_rel * diagonal;
    const double bend =
        std::max(surface_curvature(mesh_, reference_, v), curve_curvature(mesh_, v));
    if (bend > 0.0) {
        // A cubic leaves an arc of radius r and angle a by about 1e-3 r a^4; one refinement of the
        // cage, which halves a, is counted on.
        const double angle = std::pow(200.0 * options_.tolerance_rel * diagonal * bend, 0.25);
        size = std::min(size, std::clamp(angle, 0.3, 1.1) / (options_.fineness * bend));
    }
    size = std::max(size, options_.least_rel * diagonal / options_.fineness);
    const int curve = mesh_.curve_at(v);
    if (curve < 0) return size;
    const geom::FeatureCurve& c = reference_.features().curves[std::size_t(curve)];
    return c.closed ? std::min(size, c.length / 6.0) : size;
}

double SizeField::at_places(int v) const {
    std::uint32_t rounds = 0;
    for (const FinerPlace& place : options_.finer_at)
        if ((mesh_.point(v) - place.point).norm() < place.radius)
            rounds |= std::uint32_t(1) << place.round;
    return std::ldexp(1.0, -std::popcount(rounds));
}

void SizeField::add_vertex(int a, int b) {
    const int v = mesh_.vertex_count() - 1;
    size_.push_back(
        std::min(0.5 * (at(a) + at(b)), options_.scale * at_places(v) * by_curvature(v)));
}

void SizeField::limit_growth() {
    using Item = std::pair<double, int>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    for (int v = 0; v < mesh_.vertex_count(); ++v)
        if (mesh_.vertex_alive(v)) queue.emplace(at(v), v);
    while (!queue.empty()) {
        const auto [s, v] = queue.top();
        queue.pop();
        if (s > at(v)) continue;
        for (const int w : mesh_.neighbours(v)) {
            const double reach = s + options_.growth * (mesh_.point(w) - mesh_.point(v)).norm();
            if (reach >= at(w)) continue;
            size_[std::size_t(w)] = reach;
            queue.emplace(reach, w);
        }
    }
}

}  // namespace patchwright::cage
