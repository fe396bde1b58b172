// Where the lines of a layout begin: ports of singularities and of corners.
#pragma once

#include "cage/field/field_topology.h"
#include "cage/field/line_tracer.h"
#include "cage/field/lined_mesh.h"

#include <vector>

namespace patchwright::cage {

/// A direction in which one line leaves a node.
struct Port {
    int node = -1;
    LineStart start;
    bool used = false;
};

struct FieldNodes {
    std::vector<int> vertex;  ///< one a node
    std::vector<Port> ports;
    std::vector<std::vector<int>> ports_of;  ///< one a node
};

FieldNodes field_nodes(const LinedMesh& lined, const FieldTopology& topology);

}  // namespace patchwright::cage
