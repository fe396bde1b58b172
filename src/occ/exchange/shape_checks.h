// Whether a shape has all the geometry that the kernel takes for granted later.
#pragma once

#include <TopoDS_Shape.hxx>

#include <optional>
#include <string>

namespace patchwright::occ {

/// The first of: a face without a surface, an edge without any curve, coordinates or tolerances
/// that are not finite. "face 3 has no surface"; faces, edges and vertices count from 1 in the
/// order of TopExp::MapShapes.
std::optional<std::string> missing_geometry(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
