#include "geom/mesh_bend.h"

#include "geom/angle.h"
#include "geom/mesh_sides.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

namespace patchwright::geom {

namespace {

int corner_at(const TriangleMesh& mesh, int t, int v) {
    const auto& c = mesh.triangles[std::size_t(t)];
    return c[0] == v ? 0 : c[1] == v ? 1 : 2;
}

/// Numbers the corners of triangles: around a point on from triangle to triangle, but across
/// features.
void number_sectors(const TriangleMesh& mesh, const MeshFeatures& features, MeshBend& bend) {
    bend.sector.assign(mesh.triangles.size(), {-1, -1, -1});
    int count = 0;
    std::vector<int> pending;
    for (std::size_t first = 0; first < mesh.triangles.size(); ++first) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (bend.sector[first][k] >= 0) continue;
            const int v = mesh.triangles[first][k];
            pending.assign(1, int(first));
            while (!pending.empty()) {
                const auto t = std::size_t(pending.back());
                pending.pop_back();
                const int c = corner_at(mesh, int(t), v);
                int& number = bend.sector[t][std::size_t(c)];
                if (number >= 0) continue;
                number = count;
                for (const int side : {c, (c + 2) % 3}) {
                    const int other = features.beyond[t][std::size_t(side)];
                    if (other >= 0 && features.curve_under[t][std::size_t(side)] < 0)
                        pending.push_back(other);
                }
            }
            ++count;
        }
    }
    bend.normal.assign(std::size_t(count), Vec3::Zero());
    bend.shape.assign(std::size_t(count), Eigen::Matrix3d::Zero());
}

void add_normals(const TriangleMesh& mesh, MeshBend& bend) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 normal = area_vector(mesh, int(t)).normalized();
        if (!normal.allFinite()) continue;
        for (int k = 0; k < 3; ++k) {
            const Vec3 p = corner_point(mesh, int(t), k);
            const Vec3 a = corner_point(mesh, int(t), k + 1) - p;
            const Vec3 b = corner_point(mesh, int(t), k + 2) - p;
            bend.normal[std::size_t(bend.sector[t][std::size_t(k)])] +=
                angle_between(a, b) * normal;
        }
    }
    for (Vec3& n : bend.normal) {
        const double norm = n.norm();
        n = norm > 1e-12 ? Vec3(n / norm) : Vec3::Zero();
    }
}

/// The symmetric 2 x 2 matrix, in the triangle's plane, that takes sides to the change of normals
/// along them, by least squares; back in space. Nothing for triangles without a height.
std::optional<Eigen::Matrix3d> shape_of(const TriangleMesh& mesh, const MeshBend& bend, int t) {
    const Vec3 area = area_vector(mesh, t);
    const Vec3 x = (corner_point(mesh, t, 1) - corner_point(mesh, t, 0)).normalized();
    const Vec3 y = area.normalized().cross(x);
    Eigen::Matrix<double, 6, 3> rows;
    Eigen::Matrix<double, 6, 1> right;
    for (int k = 0; k < 3; ++k) {
        const Vec3 side = corner_point(mesh, t, k + 1) - corner_point(mesh, t, k);
        const auto& sector = bend.sector[std::size_t(t)];
        const Vec3 turn = bend.normal[std::size_t(sector[std::size_t((k + 1) % 3)])] -
                          bend.normal[std::size_t(sector[std::size_t(k)])];
        const double u = side.dot(x), v = side.dot(y);
        rows.row(2 * k) << u, v, 0.0;
        rows.row(2 * k + 1) << 0.0, u, v;
        right[2 * k] = turn.dot(x);
        right[2 * k + 1] = turn.dot(y);
    }
    // Triangles without a height say nothing of the bend across their longest side.
    constexpr double least_determinant_rel = 1e-12;
    const Eigen::Matrix3d normal = rows.transpose() * rows;
    Eigen::Matrix3d inverse;
    bool has_height = false;
    normal.computeInverseWithCheck(inverse, has_height,
                                   least_determinant_rel * std::pow(normal.trace(), 3));
    if (!has_height) return std::nullopt;
    const Vec3 m = inverse * (rows.transpose() * right);
    // Outward normals turn along the way where the surface bends away from them.
    return Eigen::Matrix3d(-(m[0] * x * x.transpose() +
                             m[1] * (x * y.transpose() + y * x.transpose()) +
                             m[2] * y * y.transpose()));
}

void add_shapes(const TriangleMesh& mesh, MeshBend& bend) {
    std::vector<double> weight(bend.shape.size(), 0.0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const double area = area_vector(mesh, int(t)).norm();
        if (!(area > 0.0)) continue;
        const auto shape = shape_of(mesh, bend, int(t));
        if (!shape) continue;
        for (const int s : bend.sector[t]) {
            bend.shape[std::size_t(s)] += area * *shape;
            weight[std::size_t(s)] += area;
        }
    }
    for (std::size_t s = 0; s < weight.size(); ++s)
        if (weight[s] > 0.0) bend.shape[s] /= weight[s];
}

}  // namespace

MeshBend measure_mesh_bend(const TriangleMesh& mesh, const MeshFeatures& features) {
    MeshBend bend;
    number_sectors(mesh, features, bend);
    add_normals(mesh, bend);
    add_shapes(mesh, bend);
    return bend;
}

}  // namespace patchwright::geom
