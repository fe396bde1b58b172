// Prisms and cross fields on them.
#pragma once

#include "cage/field/field_topology.h"
#include "cage/remesh/remesh.h"

#include <patchwright/geom/mesh_reference.h>

#include <array>
#include <set>
#include <utility>
#include <vector>

namespace patchwright::test {

/// Polygons in the plane, triangulated counter-clockwise, as a prism along z from 0.
struct Outline {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::array<int, 3>> triangles;
};

inline geom::TriangleMesh prism(const Outline& outline, double height) {
    geom::TriangleMesh mesh;
    const int n = int(outline.points.size());
    mesh.points.resize(2 * n, 3);
    for (int i = 0; i < n; ++i) {
        const auto& p = outline.points[std::size_t(i)];
        mesh.points.row(i) << p.x(), p.y(), 0.0;
        mesh.points.row(n + i) << p.x(), p.y(), height;
    }
    std::set<std::pair<int, int>> sides;
    for (const auto& [a, b, c] : outline.triangles) {
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({n + a, n + b, n + c});
        for (const auto& side : {std::pair{a, b}, {b, c}, {c, a}}) sides.insert(side);
    }
    for (const auto& [a, b] : sides) {
        if (sides.contains({b, a})) continue;
        mesh.triangles.push_back({a, b, n + b});
        mesh.triangles.push_back({a, n + b, n + a});
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

inline geom::EditableMesh even_mesh(const geom::MeshReference& reference) {
    geom::EditableMesh mesh(reference.surface_mesh(0.0));
    cage::RemeshOptions options;
    options.size.largest_rel = 0.04;
    options.size.scale = 0.5;
    cage::Poll poll;  // never stops
    cage::remesh(mesh, reference, options, poll);
    cage::open_corners(mesh);
    return mesh;
}

struct Field {
    explicit Field(geom::TriangleMesh triangles, cage::Poll poll = {})
        : reference(std::move(triangles)),
          mesh(even_mesh(reference)),
          field(cage::cross_field(mesh, cage::curvature_hints(mesh, reference, poll), poll)),
          topology(cage::field_topology(mesh, field)) {}

    /// Quarters of all indices: of inner vertices and of sectors.
    [[nodiscard]] int quarters() const {
        int sum = 0;
        for (const cage::Singularity& s : topology.singularities) sum += 4 - s.valence;
        for (const cage::FieldSector& s : topology.sectors) sum += 2 - s.of_field;
        return sum;
    }

    geom::MeshReference reference;
    geom::EditableMesh mesh;
    cage::CrossField field;
    cage::FieldTopology topology;
};

}  // namespace patchwright::test
