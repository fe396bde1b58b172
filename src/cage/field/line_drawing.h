// Lines that were traced become sides of triangles.
#pragma once

#include "cage/field/line_tracer.h"

#include <vector>

namespace patchwright::cage {

/// Draws a line from a vertex along traced points; sides that it crosses are split, or it goes by
/// their ends where these are near. Ends at TracedLine::end_vertex, or at the last point.
/// @param line  number in LinedMesh::lines(): the path is added to its end
/// @return the vertex that it ends at
/// @throw LayoutRefused when it crosses itself
int draw_line(LinedMesh& lined, int from, const TracedLine& traced, int line);

}  // namespace patchwright::cage
