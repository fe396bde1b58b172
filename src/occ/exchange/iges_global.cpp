#include "occ/exchange/iges_global.h"

#include <algorithm>
#include <charconv>

namespace patchwright::occ {

namespace {

/// Column 73 names the section, the columns before it are content.
constexpr std::size_t content_columns = 72;

std::string global_section(std::string_view text) {
    std::string global;
    for (std::size_t at = 0; at < text.size();) {
        const auto end = std::min(text.find_first_of("\r\n", at), text.size());
        const auto line = text.substr(at, end - at);
        if (line.size() > content_columns && line[content_columns] == 'G')
            global += line.substr(0, content_columns);
        at = end + 1;
    }
    return global;
}

std::string delimiters_of(std::string_view global) {
    std::string result = ",;";
    std::size_t at = 0;
    if (global.size() >= 3 && global.substr(0, 2) == "1H") {
        result[0] = global[2];
        at = 3;
    }
    // The first parameter ends with its own delimiter.
    if (at < global.size() && global[at] == result[0]) ++at;
    if (global.size() >= at + 3 && global.substr(at, 2) == "1H") result[1] = global[at + 2];
    return result;
}

/// Where a string that starts here ends: "5Hhello"; `at` itself where none does.
std::size_t end_of_string(std::string_view global, std::size_t at) {
    std::size_t length = 0;
    const char* const end = global.data() + global.size();
    const auto number = std::from_chars(global.data() + at, end, length);
    if (number.ec != std::errc() || number.ptr == end || *number.ptr != 'H') return at;
    const auto start = std::size_t(number.ptr + 1 - global.data());
    return start + std::min(length, global.size() - start);
}

std::string without_blanks(std::string_view text) {
    const auto first = std::min(text.find_first_not_of(' '), text.size());
    return std::string(text.substr(first, text.find_last_not_of(' ') + 1 - first));
}

}  // namespace

std::string iges_delimiters(std::string_view text) { return delimiters_of(global_section(text)); }

std::vector<std::string> iges_global_parameters(std::string_view text) {
    const std::string global = global_section(text);
    const std::string ends = delimiters_of(global);
    std::vector<std::string> result;
    for (std::size_t start = 0; start < global.size();) {
        const auto first = std::min(global.find_first_not_of(' ', start), global.size());
        const auto end =
            std::min(global.find_first_of(ends, end_of_string(global, first)), global.size());
        result.push_back(without_blanks(std::string_view(global).substr(start, end - start)));
        if (end < global.size() && global[end] == ends[1]) break;
        start = end + 1;
    }
    return result;
}

}  // namespace patchwright::occ
