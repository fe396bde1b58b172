// Where CreaseRule::ParabolicRunout acts.
#pragma once

#include <patchwright/mesh/topology.h>

#include <cstdint>
#include <vector>

namespace patchwright::mesh {

/// Ends of lines along edges. All empty where there are none.
struct Runouts {
    std::vector<std::uint8_t> of_edge;  ///< bit 0: at the edge's start, bit 1: at its end
    std::vector<char> near_face;        ///< regular faces on which one may act
};

Runouts find_runouts(const Topology& t);

}  // namespace patchwright::mesh
