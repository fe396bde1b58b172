#include "occ/exchange/temporary_file.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>

namespace patchwright::occ {

TemporaryFile::TemporaryFile(std::string_view text, std::string_view extension) {
    std::error_code error;
    const auto folder = std::filesystem::temp_directory_path(error);
    std::string name = (folder / fmt::format("patchwright-XXXXXX{}", extension)).string();
    const int file = error ? -1 : ::mkstemps(name.data(), int(extension.size()));
    if (file < 0) {
        throw base::InputError(
            fmt::format("{}: no temporary file can be made for a repaired copy of the input; set "
                        "TMPDIR to a folder that can be written",
                        folder.string()));
    }
    ::close(file);
    path_ = name;
    std::ofstream stream(path_, std::ios::binary);
    stream.write(text.data(), std::streamsize(text.size()));
    stream.close();
    if (stream) return;
    std::filesystem::remove(path_, error);
    throw base::InputError(
        fmt::format("{}: cannot be written with a repaired copy of the input; disk full?", name));
}

TemporaryFile::~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
}

}  // namespace patchwright::occ
