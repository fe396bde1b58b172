// Errors of known writers of IGES files that can be put right without guessing.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace patchwright::occ {

struct IgesRepair {
    std::string text;                  ///< the whole file
    std::vector<std::string> notices;  ///< one line each, for the user
};

/// Parameter records whose last delimiter stands in column 65, which belongs to nobody (pySpline
/// writes five fields of 13 columns): the kernel reads on into the next record. Such records are
/// moved left by a blank in front of a number.
/// @param text  a file in fixed form
/// @return nothing when the file needs no repair, or when a record has no blank to give
std::optional<IgesRepair> repair_iges(const std::string& text);

}  // namespace patchwright::occ
