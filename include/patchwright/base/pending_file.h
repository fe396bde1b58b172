// Output files appear complete or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace patchwright::base {

/// A file under construction beside its final name, renamed onto it by commit(). Destroyed without
/// commit() it removes what was written and leaves an older file of the final name untouched.
class PendingFile {
  public:
    /// @throw OutputError when the folder does not exist or cannot be written
    explicit PendingFile(std::filesystem::path final_path);
    ~PendingFile();
    PendingFile(const PendingFile&) = delete;
    PendingFile& operator=(const PendingFile&) = delete;

    /// Where to write. Has the final name's extension, as kernels choose formats by it.
    [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }

    /// @throw OutputError when the rename fails
    void commit();

  private:
    std::filesystem::path final_;
    std::filesystem::path temporary_;
    bool committed_ = false;
};

/// Writes `text` as the whole content of `path`, atomically.
/// @throw OutputError when it cannot be written
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace patchwright::base
