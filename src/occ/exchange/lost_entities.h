// What a file holds and the kernel's readers leave out without an error.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <string_view>
#include <vector>

class IGESControl_Reader;
class STEPControl_Reader;
class TopoDS_Shape;

namespace patchwright::occ {

/// Entities that should have given faces of `shape`, in the order of the file.
/// @param shape  all that the reader transferred
/// @param text   the file
std::vector<LostEntity> lost_in_step(STEPControl_Reader& reader, const TopoDS_Shape& shape,
                                     std::string_view text);
std::vector<LostEntity> lost_in_iges(IGESControl_Reader& reader, const TopoDS_Shape& shape);

}  // namespace patchwright::occ
