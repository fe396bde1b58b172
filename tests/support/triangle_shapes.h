// Triangulated shapes with known answers.
#pragma once

#include <patchwright/geom/triangle_mesh.h>

#include <cmath>

namespace patchwright::test {

/// Points of parallels and meridians, joined at the seam and at the poles.
inline geom::TriangleMesh triangle_sphere(double radius, int around) {
    geom::TriangleMesh mesh;
    const int rows = around / 2;
    const auto number = [&](int i, int j) {
        if (i == 0) return 0;
        if (i == rows) return 1;
        return 2 + (i - 1) * around + j % around;
    };
    mesh.points.resize(2 + (rows - 1) * around, 3);
    mesh.points.row(0) << 0, 0, radius;
    mesh.points.row(1) << 0, 0, -radius;
    for (int i = 1; i < rows; ++i)
        for (int j = 0; j < around; ++j) {
            const double t = M_PI * i / rows, p = 2.0 * M_PI * j / around;
            mesh.points.row(number(i, j)) << radius * std::sin(t) * std::cos(p),
                radius * std::sin(t) * std::sin(p), radius * std::cos(t);
        }
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < around; ++j) {
            if (i > 0) mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i, j + 1)});
            if (i + 1 < rows)
                mesh.triangles.push_back(
                    {number(i, j + 1), number(i + 1, j), number(i + 1, j + 1)});
        }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// From the origin to (a, b, c), two triangles a side.
inline geom::TriangleMesh triangle_box(double a, double b, double c) {
    geom::TriangleMesh mesh;
    mesh.points.resize(8, 3);
    for (int i = 0; i < 8; ++i)
        mesh.points.row(i) << ((i & 1) != 0 ? a : 0), ((i & 2) != 0 ? b : 0),
            ((i & 4) != 0 ? c : 0);
    for (const auto& q : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                          std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// A box of a x a x height without its quarter beyond (b, b).
inline geom::TriangleMesh triangle_bracket(double a, double b, double height) {
    const std::array<std::array<double, 2>, 6> corners{
        {{0, 0}, {a, 0}, {a, b}, {b, b}, {b, a}, {0, a}}};
    geom::TriangleMesh mesh;
    mesh.points.resize(12, 3);
    for (int i = 0; i < 12; ++i)
        mesh.points.row(i) << corners[std::size_t(i % 6)][0], corners[std::size_t(i % 6)][1],
            (i < 6 ? 0.0 : height);
    for (int i = 0; i < 6; ++i) {
        const int j = (i + 1) % 6;
        mesh.triangles.push_back({i, j, 6 + j});
        mesh.triangles.push_back({i, 6 + j, 6 + i});
    }
    for (const auto& t :
         {std::array{0, 1, 2}, std::array{0, 2, 3}, std::array{0, 3, 4}, std::array{0, 4, 5}}) {
        mesh.triangles.push_back({6 + t[0], 6 + t[1], 6 + t[2]});
        mesh.triangles.push_back({t[0], t[2], t[1]});
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// Along z from 0, of that many sides; the ends are fans around their middles.
inline geom::TriangleMesh triangle_cylinder(double radius, double height, int around) {
    geom::TriangleMesh mesh;
    mesh.points.resize(2 * around + 2, 3);
    for (int j = 0; j < around; ++j) {
        const double p = 2.0 * M_PI * j / around;
        mesh.points.row(j) << radius * std::cos(p), radius * std::sin(p), 0.0;
        mesh.points.row(around + j) << radius * std::cos(p), radius * std::sin(p), height;
    }
    mesh.points.row(2 * around) << 0, 0, 0;
    mesh.points.row(2 * around + 1) << 0, 0, height;
    for (int j = 0; j < around; ++j) {
        const int k = (j + 1) % around;
        mesh.triangles.push_back({j, k, around + k});
        mesh.triangles.push_back({j, around + k, around + j});
        mesh.triangles.push_back({2 * around, k, j});
        mesh.triangles.push_back({2 * around + 1, around + j, around + k});
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// Every triangle with points of its own, as STL files have them.
inline geom::TriangleMesh loose(const geom::TriangleMesh& mesh) {
    geom::TriangleMesh result;
    result.points.resize(Eigen::Index(3 * mesh.triangles.size()), 3);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k)
            result.points.row(Eigen::Index(3 * t + k)) = mesh.points.row(mesh.triangles[t][k]);
        result.triangles.push_back({int(3 * t), int(3 * t + 1), int(3 * t + 2)});
    }
    result.part = mesh.part;
    return result;
}

}  // namespace patchwright::test
