// The elements of a VTK XML file, without the data that they hold.
#pragma once

#include "vtu_bytes.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace patchwright::cli {

/// One <DataArray>.
struct VtuArray {
    std::string section;  ///< the element that it stands in: Points, PointData, ...
    std::map<std::string, std::string> attributes;
    std::string_view text;  ///< of the file
    std::uint64_t line = 0;

    /// Empty where it is not given.
    [[nodiscard]] std::string attribute(const std::string& name) const;
    [[nodiscard]] std::string name() const { return attribute("Name"); }
};

/// One <Piece>.
struct VtuPiece {
    std::string points, cells;  ///< their numbers, as they are given
    std::vector<VtuArray> arrays;
};

struct VtuElements {
    VtuEncoding encoding;
    std::vector<VtuPiece> pieces;
    bool has_appended_base64 = false;
    std::string_view appended;  ///< what follows the underscore
};

/// @param content  of the file, which outlives the result
/// @throw InputError when it is no such file, naming the line
VtuElements parse_vtu(const std::string& file, std::string_view content);

}  // namespace patchwright::cli
