// Lines across the rings that the lines of a field leave.
#pragma once

#include "cage/field/line_tracer.h"

#include <vector>

namespace patchwright::cage {

/// Where lines begin that part rings, as bands around cylinders are, into four pieces each: on the
/// shorter border, where other lines end there if these are near, and at right angles to it.
std::vector<LineStart> ring_cuts(const LinedMesh& lined);

}  // namespace patchwright::cage
