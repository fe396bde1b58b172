// Fields of sizes and of a solver's quantities: numbers at points.
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/geom/types.h>

#include <string>
#include <vector>

namespace patchwright::cli {

struct PointValues {
    geom::Points at;  ///< millimetres
    std::vector<double> values;
};

struct PointValuesOptions {
    base::LengthUnit unit = base::LengthUnit::Millimetre;  ///< of the points' coordinates
    std::string array;                                     ///< of a .vtu file; see read_vtu()
    std::string usual_array;
    bool must_be_positive = false;
};

/// Reads X,Y,Z,VALUE a line, or a .vtu file.
/// @throw InputError naming file, line or array, and value
PointValues read_point_values(const std::string& file, const PointValuesOptions& options);

}  // namespace patchwright::cli
