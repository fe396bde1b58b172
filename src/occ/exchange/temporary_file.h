// A file that is gone when its object is.
#pragma once

#include <filesystem>
#include <string_view>

namespace patchwright::occ {

class TemporaryFile {
  public:
    /// Writes `text` to a new file in the system's folder for temporary files.
    /// @throw InputError when that is not possible
    TemporaryFile(std::string_view text, std::string_view extension);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace patchwright::occ
