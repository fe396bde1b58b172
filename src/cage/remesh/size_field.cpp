#include "cage/remesh/size_field.h"

#include "geom/angle.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Share of the way from a corner of a triangle to its middle at which the surface is looked at.
constexpr double inside = 0.1;
// Edges of a closed feature curve: fewer do not show that it is round.
constexpr double fewest_edges_of_loop = 6.0;
// Between two calls of Poll, which only the calling thread may make.
constexpr std::size_t vertices_at_once = 2048;

/// Of the surface on all sides of a vertex: feet are taken a little inside each triangle, as at a
/// sharp edge the nearest point is on one face only.
double surface_curvature(const geom::EditableMesh& mesh, const geom::ModelSurface& reference,
                         int v) {
    double largest = 0.0;
    for (const int t : mesh.fan(v)) {
        const auto& c = mesh.triangle(t);
        const Vec3 middle = (mesh.point(c[0]) + mesh.point(c[1]) + mesh.point(c[2])) / 3.0;
        const Vec3 normal = mesh.area_vector(t).normalized();
        if (!normal.allFinite()) continue;
        const geom::FootPoint foot =
            reference.foot_point((1.0 - inside) * mesh.point(v) + inside * middle, normal);
        const auto curvature = reference.curvature(foot);
        if (!curvature) continue;
        largest = std::max({largest, std::abs(curvature->value[0]), std::abs(curvature->value[1])});
    }
    return largest;
}

double curve_curvature(const geom::EditableMesh& mesh, int v) {
    if (mesh.kind(v) != geom::VertexKind::Curve) return 0.0;
    const auto next = mesh.feature_neighbours(v);
    const Vec3 a = mesh.point(v) - mesh.point(next[0]), b = mesh.point(next[1]) - mesh.point(v);
    const double length = 0.5 * (a.norm() + b.norm());
    return length > 0.0 ? geom::angle_between(a, b) / length : 0.0;
}

}  // namespace

double angle_of_edge(double tolerance_rel, double diagonal, double curvature) {
    // A cubic leaves an arc of radius r and angle a by about 1e-3 r a^4, and refinement halves a:
    // to first order a^4 is 16 / 1e-3 times the tolerance by r. Surfaces bend along both directions
    // and cages are uneven, so an 80th of that is taken: a third of the angle.
    constexpr double inverse_error = 200.0;
    // 17 degrees: shorter edges gain nothing. 63 degrees: quads on longer ones fold.
    constexpr double least_rad = 0.3, most_rad = 1.1;
    return std::clamp(std::pow(inverse_error * tolerance_rel * diagonal * curvature, 0.25),
                      least_rad, most_rad);
}

SizeField::SizeField(const geom::EditableMesh& mesh, const geom::ModelSurface& reference,
                     const SizeOptions& options, Poll& poll)
    : mesh_(mesh),
      reference_(reference),
      options_(options),
      size_(std::size_t(mesh.vertex_count()), 0.0) {
    for (std::size_t start = 0; start < size_.size(); start += vertices_at_once) {
        poll();
        const std::size_t count = std::min(vertices_at_once, size_.size() - start);
        base::parallel_for(count, 64, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = start + first; i < start + last; ++i)
                if (mesh_.vertex_alive(int(i))) size_[i] = by_curvature(int(i));
        });
    }
    limit_growth();
    add_finer_regions();
    for (double& s : size_) s *= options.scale;
}

double SizeField::by_curvature(int v) const {
    const double diagonal = reference_.size();
    double size = options_.largest_rel * diagonal;
    const double bend =
        std::max(surface_curvature(mesh_, reference_, v), curve_curvature(mesh_, v));
    if (bend > 0.0) {
        const double angle = angle_of_edge(options_.tolerance_rel, diagonal, bend);
        size = std::min(size, angle / (options_.fineness * bend));
    }
    size = std::max(size, options_.least_rel * diagonal / options_.fineness);
    const int curve = mesh_.curve_at(v);
    if (curve < 0) return size;
    const geom::FeatureCurve& c = reference_.features().curves[std::size_t(curve)];
    return c.closed ? std::min(size, c.length / fewest_edges_of_loop) : size;
}

double SizeField::near_finer_regions(int v, double size,
                                     const std::vector<FinerBall>& balls) const {
    bool inside = false;
    double most = std::numeric_limits<double>::infinity();
    for (const FinerBall& finer : balls) {
        const double distance = (mesh_.point(v) - finer.ball.centre).norm();
        inside = inside || distance < finer.ball.radius_mm;
        most = std::min(most, finer.size + options_.growth * distance);
    }
    return std::min(inside ? balls.front().factor * size : size, most);
}

double SizeField::near_finer_regions(int v, double size) const {
    for (const std::vector<FinerBall>& balls : finer_) size = near_finer_regions(v, size, balls);
    return size;
}

void SizeField::add_finer_regions() {
    for (const FinerRegion& region : options_.finer_at) {
        if (region.balls.empty()) continue;
        // Edges may be longer than balls are wide: then it is the middle that counts.
        std::vector<FinerBall> balls;
        for (const FinerRegion::Ball& ball : region.balls) {
            double nearest = std::numeric_limits<double>::infinity(), size = nearest;
            for (int v = 0; v < mesh_.vertex_count(); ++v) {
                const double distance = (mesh_.point(v) - ball.centre).norm();
                if (!mesh_.vertex_alive(v) || distance >= nearest) continue;
                nearest = distance;
                size = at(v);
            }
            const double factor = region.edge_length_factor;
            balls.push_back({ball, factor, factor * size});
        }
        for (int v = 0; v < mesh_.vertex_count(); ++v)
            size_[std::size_t(v)] = near_finer_regions(v, at(v), balls);
        finer_.push_back(std::move(balls));
    }
}

void SizeField::add_vertex(int a, int b) {
    const int v = mesh_.vertex_count() - 1;
    double size = options_.scale * near_finer_regions(v, by_curvature(v));
    for (const int end : {a, b})
        size =
            std::min(size, at(end) + options_.growth * (mesh_.point(v) - mesh_.point(end)).norm());
    size_.push_back(size);
}

void SizeField::limit_growth() {
    std::vector<std::pair<int, double>> asked_for;
    for (int v = 0; v < mesh_.vertex_count(); ++v)
        if (mesh_.vertex_alive(v)) asked_for.emplace_back(v, at(v));
    const auto grown =
        geom::shortest_paths(size_.size(), asked_for, [&](int v, double size, const auto& reach) {
            for (const int w : mesh_.neighbours(v))
                reach(w, size + options_.growth * (mesh_.point(w) - mesh_.point(v)).norm());
        });
    for (const auto& [v, size] : asked_for) size_[std::size_t(v)] = grown.length[std::size_t(v)];
}

}  // namespace patchwright::cage
