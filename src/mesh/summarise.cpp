#include <patchwright/mesh/cage.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace patchwright::mesh {

bool is_extraordinary(const Topology& topology, VertexId v) {
    // Faces between one infinitely sharp edge and the next, counter-clockwise from the first
    // half-edge.
    std::vector<int> sectors{0};
    const CornerId first = topology.corner(v);
    const auto sharp = [&](CornerId c) { return std::isinf(topology.sharpness(topology.edge(c))); };
    CornerId c = first;
    do {
        if (sharp(c) && c != first) sectors.push_back(0);
        ++sectors.back();
        if (topology.is_shifted(c)) return true;
        c = topology.rotate(c);
    } while (c.valid() && c != first);
    const bool boundary = topology.is_boundary(v);
    if (!boundary && !sharp(first) && sectors.size() > 1) {
        sectors.front() += sectors.back();  // the last sector goes on in the first
        sectors.pop_back();
    }
    const std::size_t sharp_edges = boundary             ? sectors.size() + 1
                                    : sharp(first)       ? sectors.size()
                                    : sectors.size() > 1 ? sectors.size()
                                                         : 0;
    const bool dart = !boundary && sharp_edges == 1;
    const bool corner = std::isinf(topology.sharpness(v)) || sharp_edges > 2;
    if (sharp_edges == 0) return corner || sectors[0] != 4;
    const int regular = corner ? 1 : 2;
    return dart || std::any_of(sectors.begin(), sectors.end(), [&](int n) { return n != regular; });
}

CageSummary summarise(const Topology& topology) {
    CageSummary summary;
    summary.vertices = topology.vertex_count();
    summary.faces = topology.face_count();
    for (const FaceId f : topology.faces()) summary.non_quads += topology.size(f) != 4 ? 1 : 0;
    for (const EdgeId e : topology.edges()) {
        if (topology.is_boundary(e)) {
            ++summary.boundary_edges;
        } else if (topology.sharpness(e) > 0.0) {
            ++summary.creases;
        }
    }
    for (const VertexId v : topology.vertices()) {
        summary.corners += topology.tagged_sharpness(v) > 0.0 ? 1 : 0;
        summary.pins += topology.is_pinned(v) ? 1 : 0;
        summary.extraordinary += is_extraordinary(topology, v) ? 1 : 0;
    }
    return summary;
}

}  // namespace patchwright::mesh
