// Values at points from VTK's XML files of unstructured grids (.vtu).
#pragma once

#include <patchwright/geom/types.h>

#include <string>
#include <vector>

namespace patchwright::cli {

/// One number a point, or a cell and its middle.
struct VtuValues {
    std::string array;  ///< its name
    bool of_cells = false;
    geom::Points at;
    std::vector<double> values;
};

/// Reads data as text, in base64 and appended raw or in base64, with lengths of 32 or 64 bits, in
/// either byte order, compressed by zlib or not; pieces one after the other. Points and values are
/// finite.
/// @param array  name of an array with one component, of the points or else of the cells; empty:
/// one
///               named `usual`, or else the only one there is
/// @throw InputError naming file, element and value
VtuValues read_vtu(const std::string& file, const std::string& array, const std::string& usual);

}  // namespace patchwright::cli
