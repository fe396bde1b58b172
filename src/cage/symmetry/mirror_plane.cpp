#include "cage/symmetry/mirror_plane.h"

#include "geom/symmetric_eigen.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Share of the largest moment: where two are nearer to each other, they tell no directions between
// their axes, and the one plane across the third may be the longest of all, as in a square plate.
constexpr double least_gap = 0.01;
// Points that planes are adjusted to, and steps of that: moments of triangles give their normals to
// some 1e-3 radians, and each step squares the error.
constexpr std::size_t adjusting_points = 500;
constexpr int adjusting_steps = 6;

struct Moments {
    Vec3 centre = Vec3::Zero();
    geom::SymmetricEigen second;  ///< of the surface about its centre
};

Moments moments_of(const SurfaceBody& body) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    const Vec3 origin = mesh.points.row(mesh.triangles[at(body.triangles[0])][0]);
    double area = 0.0;
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const int t : body.triangles) {
        std::array<Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = mesh.points.row(mesh.triangles[at(t)][k]).transpose() - origin;
        const double a = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
        const Vec3 sum = p[0] + p[1] + p[2];
        Eigen::Matrix3d products = sum * sum.transpose();
        for (const Vec3& q : p) products += q * q.transpose();
        area += a;
        first += a / 3.0 * sum;
        second += a / 12.0 * products;
    }
    Moments result;
    if (area == 0.0) return result;
    result.centre = origin + first / area;
    result.second =
        geom::symmetric_eigen(second / area - first * first.transpose() / (area * area));
    return result;
}

std::vector<Vec3> vertices_of(const SurfaceBody& body) {
    std::vector<char> seen(at(int(body.mesh->points.rows())), 0);
    std::vector<Vec3> result;
    for (const int t : body.triangles)
        for (const int v : body.mesh->triangles[at(t)])
            if (std::exchange(seen[at(v)], 1) == 0) result.emplace_back(body.mesh->points.row(v));
    return result;
}

/// Gauss-Newton steps towards mirror images that lie on the tangent planes at their foot points.
MirrorPlane adjusted(MirrorPlane plane, const Vec3& centre, const std::vector<Vec3>& points,
                     const geom::ModelSurface& reference, Poll& poll) {
    const std::size_t stride = std::max<std::size_t>(1, points.size() / adjusting_points);
    for (int step = 0; step < adjusting_steps; ++step) {
        const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
        Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
        Vec3 right = Vec3::Zero();
        for (std::size_t i = 0; i < points.size(); i += stride) {
            poll();
            const Vec3 image = plane.mirrored(points[i]);
            const geom::FootPoint foot = reference.foot_point(image);
            const Vec3& m = foot.normal;
            const Vec3 from_centre = points[i] - centre;
            const double h = plane.height(points[i]), across = m.dot(plane.normal);
            // By turns of the normal towards u and v about the centre, and by the offset.
            const Vec3 slope = -2.0 * Vec3(u.dot(from_centre) * across + h * m.dot(u),
                                           v.dot(from_centre) * across + h * m.dot(v), -across);
            normal_matrix += slope * slope.transpose();
            right -= slope * m.dot(image - foot.point);
        }
        if (normal_matrix.diagonal().minCoeff() <= 0.0) return plane;
        const Vec3 by = normal_matrix.ldlt().solve(right);
        if (!by.allFinite()) return plane;
        const double at_centre = plane.height(centre);
        plane.normal = (plane.normal + by[0] * u + by[1] * v).normalized();
        plane.offset = plane.normal.dot(centre) - at_centre + by[2];
    }
    return plane;
}

/// Whether mirror images of points are on the reference.
bool mirrors(const MirrorPlane& plane, const std::vector<Vec3>& points,
             const geom::ModelSurface& reference, double within_mm, Poll& poll) {
    return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
        poll();
        return reference.foot_point(plane.mirrored(p)).distance <= within_mm;
    });
}

bool mirrors_curves(const MirrorPlane& plane, const SurfaceBody& body,
                    const geom::ModelSurface& reference, double within_mm, Poll& poll) {
    std::vector<char> mine(at(int(body.mesh->points.rows())), 0);
    for (const int t : body.triangles)
        for (const int v : body.mesh->triangles[at(t)]) mine[at(v)] = 1;
    for (const geom::FeatureSide& side : body.mesh->features) {
        const geom::FeatureKind kind = reference.features().curves[at(side.curve)].kind;
        if (mine[at(side.v0)] == 0 || kind == geom::FeatureKind::Smooth) continue;
        poll();
        const Vec3 middle = 0.5 * (body.mesh->points.row(side.v0) + body.mesh->points.row(side.v1));
        const Vec3 on_curve = reference.nearest_on_curve(side.curve, middle).point;
        const auto image = reference.feature_point(plane.mirrored(on_curve), kind);
        if (!image || image->distance > within_mm) return false;
    }
    return true;
}

double section_length(const MirrorPlane& plane, const SurfaceBody& body) {
    double length = 0.0;
    for (const int t : body.triangles) {
        std::array<Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = body.mesh->points.row(body.mesh->triangles[at(t)][k]);
        std::vector<Vec3> crossings;
        for (std::size_t k = 0; k < 3; ++k) {
            const double a = plane.height(p[k]), b = plane.height(p[(k + 1) % 3]);
            if ((a < 0.0) != (b < 0.0))
                crossings.emplace_back(p[k] + a / (a - b) * (p[(k + 1) % 3] - p[k]));
        }
        if (crossings.size() == 2) length += (crossings[1] - crossings[0]).norm();
    }
    return length;
}

}  // namespace

std::optional<MirrorPlane> mirror_plane(const SurfaceBody& body,
                                        const geom::ModelSurface& reference, double within_mm,
                                        Poll& poll) {
    const Moments moments = moments_of(body);
    const std::vector<Vec3> points = vertices_of(body);
    const Vec3& values = moments.second.values;
    std::optional<MirrorPlane> best;
    if (!(std::min(values[1] - values[0], values[2] - values[1]) > least_gap * values[2]))
        return best;
    double shortest = base::infinity;
    for (int k = 0; k < 3; ++k) {
        // Signs of eigenvectors mean nothing.
        MirrorPlane plane{.normal = moments.second.vectors.col(k)};
        Eigen::Index largest = 0;
        plane.normal.cwiseAbs().maxCoeff(&largest);
        if (plane.normal[largest] < 0.0) plane.normal = -plane.normal;
        plane.offset = plane.normal.dot(moments.centre);
        plane = adjusted(plane, moments.centre, points, reference, poll);
        if (!mirrors(plane, points, reference, within_mm, poll) ||
            !mirrors_curves(plane, body, reference, within_mm, poll))
            continue;
        const double length = section_length(plane, body);
        if (length >= shortest) continue;
        shortest = length;
        best = plane;
    }
    return best;
}

}  // namespace patchwright::cage
