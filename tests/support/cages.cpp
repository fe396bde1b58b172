#include "support/cages.h"

#include <patchwright/base/error.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace patchwright::test {

namespace {

using Polygon = std::vector<int>;

/// The surface of a cube with n x n quads a side, vertices shared.
void cube_grid(int n, std::vector<geom::Vec3>& points, std::vector<Polygon>& faces) {
    std::map<std::array<int, 3>, int> known;
    const auto vertex = [&](const std::array<int, 3>& at) {
        const auto [entry, added] = known.try_emplace(at, static_cast<int>(points.size()));
        if (added) points.emplace_back(at[0], at[1], at[2]);
        return entry->second;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {0, n}) {
            for (int i = 0; i < n; ++i) {
                for (int j = 0; j < n; ++j) {
                    const auto at = [&](int a, int b) {
                        std::array<int, 3> p{};
                        p[std::size_t(axis)] = side;
                        p[std::size_t(axis + 1) % 3] = a;
                        p[std::size_t(axis + 2) % 3] = b;
                        return vertex(p);
                    };
                    faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
                    if (side == 0) std::reverse(faces.back().begin(), faces.back().end());
                }
            }
        }
    }
}

/// A closed surface of 2 n quads: two poles of valence n, all others of valence 3.
void trapezohedron(int n, std::vector<geom::Vec3>& points, std::vector<Polygon>& faces) {
    points = {{1, 1, 2}, {1, 1, 0}};
    for (int k = 0; k < 2 * n; ++k) {
        const double a = M_PI * k / n;
        points.emplace_back(1 + std::cos(a), 1 + std::sin(a), 1.0 + (k % 2 == 0 ? 0.3 : -0.3));
    }
    const auto ring = [&](int k) { return 2 + (k + 2 * n) % (2 * n); };
    for (int i = 0; i < n; ++i) {
        faces.push_back({0, ring(2 * i), ring(2 * i + 1), ring(2 * i + 2)});
        faces.push_back({1, ring(2 * i + 1), ring(2 * i), ring(2 * i - 1)});
    }
}

/// Joins `b` to `a` across the edge they share; empty when they share none or more than one.
Polygon join(const Polygon& a, const Polygon& b) {
    std::vector<std::pair<std::size_t, std::size_t>> shared;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t j = 0; j < b.size(); ++j) {
            if (a[i] == b[(j + 1) % b.size()] && a[(i + 1) % a.size()] == b[j])
                shared.emplace_back(i, j);
        }
    }
    if (shared.size() != 1) return {};
    const auto [i, j] = shared[0];
    Polygon joined;
    for (std::size_t k = 1; k <= a.size(); ++k) joined.push_back(a[(i + k) % a.size()]);
    for (std::size_t k = 2; k < b.size(); ++k) joined.push_back(b[(j + k) % b.size()]);
    return joined;
}

}  // namespace

mesh::Cage random_cage(unsigned seed, const RandomCageOptions& options) {
    for (unsigned attempt = 0;; ++attempt) {
        std::mt19937 random(seed + 7919 * attempt);
        const auto chance = [&](double p) {
            return std::uniform_real_distribution<>(0, 1)(random) < p;
        };
        const auto pick = [&](std::size_t n) {
            return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
        };
        std::vector<geom::Vec3> points;
        std::vector<Polygon> faces;
        if (options.valence > 0) {
            trapezohedron(options.valence, points, faces);
        } else {
            cube_grid(2 + int(pick(2)), points, faces);
        }
        for (geom::Vec3& p : points) {
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += std::uniform_real_distribution<>(-0.2, 0.2)(random);
        }
        if (options.merge_faces) {
            for (int joins = int(pick(5)); joins > 0; --joins) {
                const std::size_t a = pick(faces.size());
                const std::size_t b = pick(faces.size());
                const Polygon joined = a == b ? Polygon{} : join(faces[a], faces[b]);
                if (joined.empty()) continue;
                faces[a] = joined;
                faces.erase(faces.begin() + std::ptrdiff_t(b));
            }
        }
        if (options.open) {
            for (int holes = 1 + int(pick(3)); holes > 0; --holes) {
                faces.erase(faces.begin() + std::ptrdiff_t(pick(faces.size())));
            }
        }
        std::set<int> used;
        for (const Polygon& face : faces) used.insert(face.begin(), face.end());
        if (used.size() != points.size()) continue;  // a removed face left a vertex alone

        mesh::TopologyInput tags;
        tags.boundary_rule = options.rule;
        const auto sharpness = [&] {
            return options.semi_sharp && chance(0.7) ? double(16 + pick(180)) / 64.0
                                                     : mesh::infinite_sharpness;
        };
        for (const Polygon& face : faces) {
            for (std::size_t i = 0; i < face.size(); ++i) {
                const int a = face[i];
                const int b = face[(i + 1) % face.size()];
                if (a < b && chance(options.crease_share))
                    tags.creases.push_back({a, b, sharpness()});
            }
            if (chance(0.3 * options.crease_share)) tags.corners.push_back({face[0], sharpness()});
        }
        try {
            return make_cage(points, faces, std::move(tags));
        } catch (const base::InputError&) {
            // Not manifold: take the next attempt.
        }
    }
}

}  // namespace patchwright::test
