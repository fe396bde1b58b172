#include "files.h"

#include <patchwright/adapt/write.h>
#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>
#include <patchwright/grid/write.h>
#include <patchwright/occ/cad_model.h>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace patchwright::cli {

namespace {

namespace fs = std::filesystem;

void check_extension(const OutputFile& output, std::vector<std::string> allowed) {
    for (const std::string& extension : allowed)
        if (has_extension(output.file, extension)) return;
    throw base::UsageError(
        fmt::format("{}: {} writes {}", output.file, output.option, fmt::join(allowed, " or ")));
}

void check_kind(const OutputFile& output, const base::OutputTarget& target) {
    switch (output.kind) {
        case OutputKind::Cad: try { occ::file_format(output.file);
            } catch (const base::InputError& error) {
                throw base::UsageError(error.what());
            }
            break;
        case OutputKind::Cage: check_extension(output, {".obj"}); break;
        case OutputKind::Grid: grid::grid_format(output.file); break;
        case OutputKind::LocalGrid: adapt::local_format(output.file); break;
        case OutputKind::Field: check_extension(output, {".vtp", ".glb"}); break;
        case OutputKind::Picture: check_extension(output, {".png"}); break;
        case OutputKind::Table: check_extension(output, {".csv"}); break;
        case OutputKind::Matrix: check_extension(output, {".mtx"}); break;
        case OutputKind::Json:
            if (!target.is_stream) check_extension(output, {".json"});
            break;
        case OutputKind::Html:
            if (!target.is_stream) check_extension(output, {".html", ".htm"});
            break;
    }
}

/// The folder of a .vtm file's blocks, where there is one, can be written.
void check_block_folder(const OutputFile& output, const base::OutputTarget& target) {
    if (output.kind != OutputKind::Grid || grid::grid_format(output.file) != grid::GridFormat::Vtk)
        return;
    const fs::path folder = target.folder() / target.file.stem();
    if (fs::exists(folder)) base::OutputTarget{folder / "block.vts"};
}

/// Of a file that may not be there yet; equal for all names and links.
struct Identity {
    fs::path path;
    dev_t device = 0;
    ino_t number = 0;

    explicit Identity(const fs::path& file) {
        std::error_code ignored;
        path = fs::canonical(file.has_parent_path() ? file.parent_path() : ".", ignored) /
               file.filename();
        struct stat found {};
        if (::stat(file.c_str(), &found) == 0) {
            device = found.st_dev;
            number = found.st_ino;
        }
    }
    [[nodiscard]] bool equals(const Identity& other) const {
        return path == other.path ||
               (number != 0 && number == other.number && device == other.device);
    }
};

}  // namespace

void check_files(const RunFiles& files) {
    struct Known {
        Identity identity;
        std::string what;
    };
    std::vector<Known> known;
    for (const std::string& input : files.inputs)
        if (!input.empty()) known.push_back({Identity(input), "the input"});
    std::string to_standard_output;
    for (const OutputFile& output : files.outputs) {
        if (output.file.empty()) continue;
        const bool is_text = output.kind == OutputKind::Json || output.kind == OutputKind::Html;
        if (is_text && is_standard_output(output.file)) {
            if (!to_standard_output.empty())
                throw base::UsageError(fmt::format("{} and {} both write to standard output",
                                                   to_standard_output, output.option));
            to_standard_output = output.option;
            continue;
        }
        const base::OutputTarget target(output.file);
        check_kind(output, target);
        check_block_folder(output, target);
        if (!is_text && is_standard_output(output.file))
            throw base::UsageError(
                fmt::format("{}: {} is standard output as well; give another file", output.file,
                            output.option));
        if (target.is_stream) continue;
        const Identity identity(target.file);
        for (const Known& other : known)
            if (identity.equals(other.identity))
                throw base::UsageError(fmt::format("{}: {} is {} as well; give another file",
                                                   output.file, output.option, other.what));
        known.push_back({identity, output.option});
    }
}

bool has_extension(const std::string& file, std::string_view extension) {
    std::string own = fs::path(file).extension().string();
    std::transform(own.begin(), own.end(), own.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return own == extension;
}

bool is_standard_output(const std::string& file) {
    if (file == "-") return true;
    struct stat found {
    }, standard{};
    return ::stat(file.c_str(), &found) == 0 && ::fstat(STDOUT_FILENO, &standard) == 0 &&
           found.st_dev == standard.st_dev && found.st_ino == standard.st_ino;
}

std::string named(std::string pattern, std::string_view placeholder, const std::string& name) {
    for (std::size_t at = 0; (at = pattern.find(placeholder, at)) != std::string::npos;
         at += name.size())
        pattern.replace(at, placeholder.size(), name);
    return pattern;
}

std::string file_content(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(stream), {}};
    if (!stream.is_open() || stream.bad())
        throw base::InputError(file + ": cannot be read; is it there?");
    return content;
}

void write_standard_output(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw base::OutputError(
            fmt::format("standard output: cannot be written: {}", std::strerror(errno)));
}

void write_standard_error(std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

}  // namespace patchwright::cli
