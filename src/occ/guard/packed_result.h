// A ReadResult as bytes: the report's fields, the faces' names and colours, the shape in the
// kernel's binary format.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <string>

namespace patchwright::occ {

std::string pack_result(const ReadResult& result);

/// @param file  that was read, for messages
/// @throw InputError when the kernel cannot read what it has written, such as directions whose
///        length is zero
ReadResult unpack_result(std::string bytes, const std::string& file);

}  // namespace patchwright::occ
