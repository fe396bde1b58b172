// What a run reads and writes, checked before anything is read.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace patchwright::cli {

enum class OutputKind { Cad, Cage, Grid, LocalGrid, Field, Picture, Table, Matrix, Json, Html };

struct OutputFile {
    std::string option;  ///< as messages name it
    std::string file;    ///< empty where the option may be left out, and was
    OutputKind kind;
};

struct RunFiles {
    std::vector<std::string> inputs;  ///< empty ones are left out
    std::vector<OutputFile> outputs;
};

/// @throw UsageError for an extension that is not of the kind, and for outputs that are an input or
///        another output, by whatever names or links
/// @throw OutputError where nothing can be written; see base::OutputTarget
void check_files(const RunFiles& files);

/// Whatever the case of its letters.
/// @param extension  in small letters, with the dot
bool has_extension(const std::string& file, std::string_view extension);

/// "-", or another path of what standard output goes to.
bool is_standard_output(const std::string& file);

/// The pattern of an output's name with `name` wherever the placeholder stands.
std::string named(std::string pattern, std::string_view placeholder, const std::string& name);

/// All bytes of an input.
/// @throw InputError when it cannot be read
std::string file_content(const std::string& file);

/// @throw OutputError when not all could be written
void write_standard_output(std::string_view text);

/// What cannot be written there is lost: results and files do not depend on it.
void write_standard_error(std::string_view text);

}  // namespace patchwright::cli
