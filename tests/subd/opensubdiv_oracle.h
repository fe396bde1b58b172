// Our topologies as OpenSubdiv's.
#pragma once

#include <patchwright/mesh/topology.h>

#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace patchwright::test {

inline std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> osd_refiner(const mesh::Topology& t) {
    namespace Far = OpenSubdiv::Far;
    namespace Sdc = OpenSubdiv::Sdc;
    std::vector<int> sizes, vertices, crease_vertices, corner_vertices;
    std::vector<float> crease_sharpness, corner_sharpness;
    for (const mesh::FaceId f : t.faces()) {
        sizes.push_back(t.size(f));
        for (const mesh::CornerId c : t.corners(f)) vertices.push_back(t.vertex(c).value);
    }
    for (const mesh::EdgeId e : t.edges()) {
        if (t.tagged_sharpness(e) == 0.0) continue;
        crease_vertices.insert(crease_vertices.end(), {t.start(e).value, t.end(e).value});
        crease_sharpness.push_back(float(std::min(t.tagged_sharpness(e), 10.0)));
    }
    for (const mesh::VertexId v : t.vertices()) {
        if (t.tagged_sharpness(v) == 0.0) continue;
        corner_vertices.push_back(v.value);
        corner_sharpness.push_back(float(std::min(t.tagged_sharpness(v), 10.0)));
    }
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = t.vertex_count();
    descriptor.numFaces = t.face_count();
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = vertices.data();
    descriptor.numCreases = int(crease_sharpness.size());
    descriptor.creaseVertexIndexPairs = crease_vertices.data();
    descriptor.creaseWeights = crease_sharpness.data();
    descriptor.numCorners = int(corner_sharpness.size());
    descriptor.cornerVertexIndices = corner_vertices.data();
    descriptor.cornerWeights = corner_sharpness.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(t.boundary_rule() == mesh::BoundaryRule::EdgeOnly
                                            ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                            : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    return std::unique_ptr<Far::TopologyRefiner>(
        Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, options)));
}

}  // namespace patchwright::test
