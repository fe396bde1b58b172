#include "geom/mesh_sides.h"
#include "geom/symmetric_eigen.h"

#include <patchwright/geom/mesh_figures.h>

#include <Eigen/Geometry>
#include <limits>

namespace patchwright::geom {

namespace {

/// Integral of x x^T over a simplex of the given measure with these corners, of which there are n
/// and perhaps the origin as one more that adds nothing.
template <std::size_t n>
Eigen::Matrix3d second_moment(const std::array<Vec3, n>& corner, int corners, double measure) {
    Vec3 sum = Vec3::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const Vec3& p : corner) {
        sum += p;
        squares += p * p.transpose();
    }
    return measure / (corners * (corners + 1.0)) * (squares + sum * sum.transpose());
}

}  // namespace

MeshFigures measure_mesh(const TriangleMesh& mesh, bool of_volume) {
    MeshFigures result;
    const auto sides = sorted_sides(mesh);
    result.shortest_side = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < sides.size(); ++i) {
        ++result.sides;
        const Vec3 a = mesh.points.row(sides[i].low), b = mesh.points.row(sides[i].high);
        if ((b - a).norm() < result.shortest_side) {
            result.shortest_side = (b - a).norm();
            result.shortest_at = 0.5 * (a + b);
        }
        const bool pair = i + 1 < sides.size() && sides[i + 1].low == sides[i].low &&
                          sides[i + 1].high == sides[i].high;
        result.free_sides += pair ? 0 : 1;
        i += pair ? 1 : 0;
    }
    result.smallest_area = result.narrowest_width = std::numeric_limits<double>::infinity();
    const Vec3 origin = bounding_box(mesh.points).centre();
    double measure = 0.0;
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (int t = 0; t < int(mesh.triangles.size()); ++t) {
        std::array<Vec3, 3> p;
        double perimeter = 0.0;
        for (int k = 0; k < 3; ++k) {
            p[std::size_t(k)] = corner_point(mesh, t, k) - origin;
            perimeter += (corner_point(mesh, t, k + 1) - corner_point(mesh, t, k)).norm();
        }
        const double area = 0.5 * area_vector(mesh, t).norm();
        const double volume = p[0].dot(p[1].cross(p[2])) / 6.0;
        result.area += area;
        result.volume += volume;
        if (area < result.smallest_area) {
            result.smallest_area = area;
            result.smallest = t;
        }
        if (2.0 * area < result.narrowest_width * perimeter) {
            result.narrowest_width = 2.0 * area / perimeter;
            result.narrowest = t;
        }
        const double part = of_volume ? volume : area;
        measure += part;
        first += part * (p[0] + p[1] + p[2]) / (of_volume ? 4.0 : 3.0);
        second += second_moment(p, of_volume ? 4 : 3, part);
    }
    if (measure == 0.0) return result;
    const Vec3 centre = first / measure;
    result.centre = origin + centre;
    second -= measure * centre * centre.transpose();
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    const Vec3 moments = symmetric_eigen(inertia).values;
    for (Eigen::Index k = 0; k < 3; ++k) result.moments[std::size_t(k)] = moments[k];
    return result;
}

}  // namespace patchwright::geom
