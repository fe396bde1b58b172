// Which points of a limit surface are measured.
#pragma once

#include <patchwright/mesh/topology.h>
#include <patchwright/subd/limit_operator.h>

#include <vector>

namespace patchwright::measure {

/// Parameters ((i + 1/2) / n, (j + 1/2) / n).
subd::ParameterSet interior_grid(int n);

/// The whole face including its border: (i / n, j / n), i and j from 0 to n.
subd::ParameterSet closed_grid(int n);

/// Every face, each sector of faces that are no quads; all use set 0.
std::vector<subd::Site> face_sites(const mesh::Topology& topology);

}  // namespace patchwright::measure
