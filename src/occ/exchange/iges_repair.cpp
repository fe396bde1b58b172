#include "occ/exchange/iges_repair.h"

#include "occ/exchange/iges_global.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace patchwright::occ {

namespace {

constexpr std::size_t data_columns = 64, section_column = 72;

bool is_parameter_record(std::string_view line) {
    return line.size() > section_column && line[section_column] == 'P';
}

/// Removes one blank that cannot be part of a string: in front of the record's first number, where
/// the record before ended with a delimiter.
bool move_left(std::string& line) {
    if (line.front() != ' ') return false;
    line.erase(0, 1);
    line.insert(data_columns, 1, ' ');
    return true;
}

}  // namespace

std::optional<IgesRepair> repair_iges(const std::string& text) {
    const std::string ends = iges_delimiters(text);
    IgesRepair result;
    int moved = 0;
    bool after_delimiter = true;
    for (std::size_t at = 0; at < text.size();) {
        const auto end = std::min(text.find('\n', at), text.size());
        std::string line = text.substr(at, end - at);
        if (is_parameter_record(line)) {
            if (ends.find(line[data_columns]) != std::string::npos) {
                if (!after_delimiter || !move_left(line)) return std::nullopt;
                ++moved;
            }
            const auto last = line.find_last_not_of(' ', data_columns - 1);
            after_delimiter =
                last != std::string::npos && ends.find(line[last]) != std::string::npos;
        }
        result.text += line;
        if (end < text.size()) result.text += '\n';
        at = end + 1;
    }
    if (moved == 0) return std::nullopt;
    result.notices.push_back(fmt::format(
        "{} parameter records run into column 65, as pySpline writes them; read as meant", moved));
    return result;
}

}  // namespace patchwright::occ
