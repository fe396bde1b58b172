// Cages for tests: small closed and open ones, and seeded random ones with every kind of feature.
#pragma once

#include <patchwright/mesh/cage.h>

#include <cmath>
#include <random>
#include <vector>

namespace patchwright::test {

inline mesh::Cage make_cage(const std::vector<geom::Vec3>& points,
                            const std::vector<std::vector<int>>& faces,
                            mesh::TopologyInput tags = {}) {
    tags.vertex_count = static_cast<int>(points.size());
    for (const auto& face : faces) {
        tags.face_sizes.push_back(static_cast<int>(face.size()));
        tags.face_vertices.insert(tags.face_vertices.end(), face.begin(), face.end());
    }
    geom::Points rows(Eigen::Index(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) rows.row(Eigen::Index(i)) = points[i];
    return mesh::build_cage(std::move(tags), std::move(rows)).cage;
}

inline const std::vector<std::vector<int>> cube_faces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                      {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

/// Vertex i at (i & 1, i >> 1 & 1, i >> 2) * 2 - 1, times half the edge.
inline mesh::Cage cube(double edge, mesh::TopologyInput tags = {}) {
    std::vector<geom::Vec3> points;
    for (int i = 0; i < 8; ++i) {
        points.push_back(0.5 * edge *
                         geom::Vec3(2 * (i & 1) - 1, 2 * (i >> 1 & 1) - 1, 2 * (i >> 2) - 1));
    }
    return make_cage(points, cube_faces, std::move(tags));
}

/// An open grid of nu x nv quads over [0, nu] x [0, nv] in the plane z = 0; vertex i * (nv + 1) +
/// j.
inline mesh::Cage grid(int nu, int nv, mesh::TopologyInput tags = {}) {
    std::vector<geom::Vec3> points;
    for (int i = 0; i <= nu; ++i) {
        for (int j = 0; j <= nv; ++j) points.emplace_back(i, j, 0.0);
    }
    std::vector<std::vector<int>> faces;
    const auto at = [&](int i, int j) { return i * (nv + 1) + j; };
    for (int i = 0; i < nu; ++i) {
        for (int j = 0; j < nv; ++j)
            faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    return make_cage(points, faces, std::move(tags));
}

/// A regular closed ring of nu x nv quads with radii `major` and `minor`.
inline mesh::Cage torus(int nu, int nv, double major, double minor) {
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    for (int i = 0; i < nu; ++i) {
        for (int j = 0; j < nv; ++j) {
            const double a = 2 * M_PI * i / nu;
            const double b = 2 * M_PI * j / nv;
            const double r = major + minor * std::cos(b);
            points.emplace_back(r * std::cos(a), r * std::sin(a), minor * std::sin(b));
            const auto at = [&](int k, int l) { return (k % nu) * nv + l % nv; };
            faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return make_cage(points, faces);
}

/// A fan of `valence` quads around vertex 0, open outside: a smooth inner vertex of any valence.
inline mesh::Cage fan(int valence) {
    std::vector<geom::Vec3> points{geom::Vec3(0, 0, 0.3)};
    std::vector<std::vector<int>> faces;
    for (int k = 0; k < 2 * valence; ++k) {
        const double a = M_PI * k / valence;
        const double r = k % 2 == 0 ? 1.0 : 1.4;
        points.emplace_back(r * std::cos(a), r * std::sin(a), 0.2 * std::cos(3 * a));
    }
    for (int k = 0; k < valence; ++k) {
        faces.push_back({0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * valence)});
    }
    return make_cage(points, faces);
}

struct RandomCageOptions {
    bool open = false;        ///< leaves some faces away
    bool merge_faces = true;  ///< joins some quads into larger polygons
    double crease_share = 0.2;
    bool semi_sharp = false;  ///< some sharpnesses finite, multiples of 1/64: exact as floats
    int valence = 0;          ///< starts from two poles of this valence in place of a cube
    mesh::BoundaryRule rule = mesh::BoundaryRule::EdgeOnly;
};

/// A disturbed, partly coarsened cube grid with random creases and corners; the same for one seed.
mesh::Cage random_cage(unsigned seed, const RandomCageOptions& options = {});

}  // namespace patchwright::test
