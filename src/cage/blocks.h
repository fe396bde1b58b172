// A part of a cage while it is put together.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/mesh/topology_input.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace patchwright::cage {

struct Blocks {
    std::vector<geom::Vec3> points;       ///< on the model
    std::vector<std::vector<int>> faces;  ///< counter-clockwise seen from outside
    std::vector<std::string> groups;      ///< one a face
    std::vector<std::pair<int, int>> creases;
    std::vector<int> corners;
};

/// The feature that an edge is on, by the edge's ends, the smaller number first.
using EdgeCurves = std::map<std::pair<int, int>, int>;

struct BlocksOnCurves {
    Blocks blocks;
    EdgeCurves curves;
};

/// Adds the faces, creases and corners after what is there; groups are left to the caller.
inline void add_to(mesh::TopologyInput& input, const Blocks& part) {
    const int base = input.vertex_count;
    input.vertex_count += int(part.points.size());
    for (const std::vector<int>& face : part.faces) {
        input.face_sizes.push_back(int(face.size()));
        for (const int v : face) input.face_vertices.push_back(base + v);
    }
    for (const auto& [a, b] : part.creases)
        input.creases.push_back({base + a, base + b, mesh::infinite_sharpness});
    for (const int v : part.corners) input.corners.push_back({base + v, mesh::infinite_sharpness});
}

}  // namespace patchwright::cage
