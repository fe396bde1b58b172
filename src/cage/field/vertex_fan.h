// The triangles around a vertex in order.
#pragma once

#include "geom/editable_mesh.h"

#include <functional>
#include <vector>

namespace patchwright::cage {

/// A triangle at a vertex, on the left of the way from the vertex to `next`.
struct Wedge {
    int triangle = -1, corner = -1;  ///< corner: number of the vertex in the triangle
    int next = -1;
    double start = 0.0, angle = 0.0;  ///< radians: from the first wedge's side, and of this one
};

/// Counter-clockwise from the side v - first.
struct VertexFan {
    std::vector<Wedge> wedges;
    bool closed = false;  ///< all around; else it ends at a side that stops it
    double angle = 0.0;   ///< of all wedges, radians
    int last = -1;        ///< vertex at the end of the last wedge's far side
};

/// Whether a side of a mesh ends a fan; boundaries always do.
using StopsAt = std::function<bool(int a, int b)>;

VertexFan fan_from(const geom::EditableMesh& mesh, int v, int first, const StopsAt& stops);

/// Whether side k of a triangle is on a feature or on the boundary.
bool is_border(const geom::EditableMesh& mesh, int t, int k);

/// Triangle beyond side k; -1: none.
int across(const geom::EditableMesh& mesh, int t, int k);

/// Of one vertex; empty for one inside the surface.
std::vector<int> border_neighbours(const geom::EditableMesh& mesh, int v);

/// Any neighbour from which fan_from() can start.
int some_neighbour(const geom::EditableMesh& mesh, int v);

}  // namespace patchwright::cage
