#include "occ/exchange/file_checks.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace patchwright::occ {

namespace {

using Path = std::filesystem::path;

std::string content_of(const Path& path) {
    if (std::filesystem::is_directory(path)) refuse(path, "is a folder; give a CAD file");
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    if (!stream) refuse(path, "cannot be opened; does it exist?");
    const std::streamoff size = stream.tellg();
    if (size <= 0) refuse(path, "is empty; get a complete copy");
    std::string text(std::size_t(size), '\0');
    stream.seekg(0);
    if (!stream.read(text.data(), size)) refuse(path, "cannot be read");
    return text;
}

template <class Visit>
void each_line(std::string_view text, Visit&& visit) {
    while (!text.empty()) {
        const auto end = std::min(text.find_first_of("\r\n"), text.size());
        if (text.find_first_not_of(" \t\x1a") < end) visit(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

/// Fixed-form lines have 80 columns, of which the 73rd names the section.
char iges_section(std::string_view line) { return line.size() > 72 ? line[72] : ' '; }

/// The terminate record: a letter and seven digits for each section, e.g. "S      1G      4".
std::optional<int> promised_lines(std::string_view record, char section) {
    for (std::size_t at = 0; at + 8 <= std::min<std::size_t>(record.size(), 32); at += 8) {
        if (record[at] != section) continue;
        std::string_view digits = record.substr(at + 1, 7);
        digits.remove_prefix(std::min(digits.find_first_not_of(' '), digits.size()));
        int count = 0;
        if (std::from_chars(digits.data(), digits.data() + digits.size(), count).ec == std::errc())
            return count;
    }
    return std::nullopt;
}

}  // namespace

std::string check_step_file(const Path& path) {
    std::string text = content_of(path);
    if (text.substr(0, 1 << 16).find("ISO-10303-21;") == std::string::npos) {
        refuse(path, "is not a STEP file: it does not start with ISO-10303-21");
    }
    const auto end = text.rfind("END-ISO-10303-21;");
    if (end == std::string::npos) {
        refuse(path, "is cut off: END-ISO-10303-21 is missing; get a complete copy");
    }
    // The header ends with ENDSEC too; what follows is "DATA;" or, in edition 3, "DATA(...);".
    const auto header_end = std::min(text.find("ENDSEC;"), end);
    const auto data = text.find("DATA", header_end);
    if (data >= end) refuse(path, "has no DATA section; get a complete copy");
    if (text.rfind("ENDSEC;", end) < data) {
        refuse(path, "is cut off: the DATA section does not end; get a complete copy");
    }
    return text;
}

std::string check_iges_file(const Path& path) {
    constexpr std::string_view sections = "SGDP";
    std::array<int, sections.size()> lines{};
    std::optional<char> first;
    std::string terminate;
    std::string text = content_of(path);
    each_line(text, [&](std::string_view line) {
        const char section = iges_section(line);
        if (!first) first = section;
        if (section == 'T') terminate = line;
        if (const auto i = sections.find(section); i != std::string_view::npos) ++lines[i];
    });
    if (first != 'S' && first != 'G') {
        refuse(path,
               "is not an IGES file in fixed form: the first line has no section letter "
               "in column 73");
    }
    if (terminate.empty()) {
        refuse(path, "is cut off: the terminate section is missing; get a complete copy");
    }
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const auto promised = promised_lines(terminate, sections[i]);
        // More lines than promised lose nothing.
        if (!promised || lines[i] >= *promised) continue;
        refuse(path, "is incomplete: section {} has {} lines of {}; get a complete copy",
               sections[i], lines[i], *promised);
    }
    return text;
}

void check_brep_file(const Path& path) {
    const std::string text = content_of(path);
    if (text.substr(0, 1 << 16).find("CASCADE Topology") == std::string::npos) {
        refuse(path, "is not a BREP file in text form: the line 'CASCADE Topology' is missing");
    }
    // The last section: its number of shapes, each of which ends with a star, then the root.
    constexpr std::string_view title = "\nTShapes ";
    const auto section = text.rfind(title);
    int promised = 0;
    if (section == std::string::npos ||
        std::from_chars(text.data() + section + title.size(), text.data() + text.size(), promised)
                .ec != std::errc()) {
        refuse(path, "is cut off: the section TShapes is missing; get a complete copy");
    }
    const auto shapes = std::count(text.begin() + std::ptrdiff_t(section), text.end(), '*');
    const auto root = text.find_first_of("+-ie", text.find_last_of('*') + 1);
    if (shapes < promised || root == std::string::npos) {
        refuse(path, "is cut off: it has {} shapes of {} and {}; get a complete copy", shapes,
               promised, root == std::string::npos ? "no root" : "a root");
    }
}

}  // namespace patchwright::occ
