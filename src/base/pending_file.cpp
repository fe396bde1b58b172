#include <patchwright/base/error.h>
#include <patchwright/base/pending_file.h>

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace patchwright::base {

PendingFile::PendingFile(std::filesystem::path final_path) : final_(std::move(final_path)) {
    const auto folder =
        final_.has_parent_path() ? final_.parent_path() : std::filesystem::path(".");
    if (std::filesystem::is_directory(final_)) {
        throw OutputError(fmt::format("{}: is a folder; give a file name", final_.string()));
    }
    if (!std::filesystem::is_directory(folder)) {
        throw OutputError(
            fmt::format("{}: the folder does not exist; create it first", final_.string()));
    }
    if (::access(folder.c_str(), W_OK) != 0) {
        throw OutputError(fmt::format("{}: the folder cannot be written: {}", final_.string(),
                                      std::strerror(errno)));
    }
    static std::atomic<int> next = 0;  // several may be under way for one final name
    temporary_ = folder / fmt::format(".{}.part{}-{}{}", final_.stem().string(), ::getpid(), next++,
                                      final_.extension().string());
}

PendingFile::~PendingFile() {
    if (committed_) return;
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

void PendingFile::commit() {
    std::error_code error;
    std::filesystem::rename(temporary_, final_, error);
    if (error) {
        throw OutputError(
            fmt::format("{}: cannot be written: {}", final_.string(), error.message()));
    }
    committed_ = true;
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
    PendingFile pending(path);
    std::ofstream stream(pending.path(), std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) throw OutputError(fmt::format("{}: cannot be written: disk full?", path.string()));
    pending.commit();
}

}  // namespace patchwright::base
