// Vertices that subdivision has no rule for and that most cages do not need.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/mesh/topology.h>

#include <vector>

namespace patchwright::mesh {

/// Takes inner vertices with two faces only out of both where nothing else goes with them: they
/// have no tag, both faces keep at least three vertices, and their two edges have the same
/// sharpness and become one that was not there before.
/// @return the number that each vertex had; empty when all are still there
/// @pre    faces name existing vertices, none twice
std::vector<int> remove_two_face_vertices(TopologyInput& input, geom::Points& points);

}  // namespace patchwright::mesh
