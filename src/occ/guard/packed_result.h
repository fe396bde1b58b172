// A ReadResult as bytes: the report's fields, the faces' names and colours, the shape in the
// kernel's binary format.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <string>

namespace patchwright::occ {

std::string pack_result(const ReadResult& result);

/// @throw Error when the bytes are not such a result
ReadResult unpack_result(std::string bytes);

}  // namespace patchwright::occ
