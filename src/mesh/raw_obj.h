// An OBJ file's numbers, before anyone has checked that they are a surface.
#pragma once

#include <patchwright/mesh/obj.h>

#include <charconv>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace patchwright::mesh {

struct RawObj {
    TopologyInput input;
    geom::Points points;
    bool is_tagged = false;  ///< with what only a control mesh has
    struct LineElement {
        std::vector<int> vertices;  ///< that there are, unless the file has faces
        int line = 0;               ///< of the file
    };
    std::vector<LineElement> lines;
};

/// @throw InputError naming file and line of a malformed statement, or when there are no vertices
RawObj read_raw_obj(std::istream& stream, const std::string& source);

/// @throw InputError when it is a folder or cannot be opened
std::ifstream open_mesh_file(const std::filesystem::path& path);

/// What blanks separate.
inline std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    std::size_t at = 0;
    while ((at = line.find_first_not_of(" \t\r", at)) != std::string_view::npos) {
        const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
        words.push_back(line.substr(at, end - at));
        at = end;
    }
    return words;
}

/// Nothing when the word is no number as a whole.
template <class Number>
std::optional<Number> number_of(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

}  // namespace patchwright::mesh
