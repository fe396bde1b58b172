// A file that is in memory only: nothing is left of it however the process ends.
#pragma once

#include <filesystem>
#include <string_view>

namespace patchwright::occ {

class MemoryFile {
  public:
    /// @throw std::system_error when the system has no memory for it
    explicit MemoryFile(std::string_view content);
    ~MemoryFile();
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    /// Where this process, and no other, can open it.
    [[nodiscard]] std::filesystem::path path() const;

  private:
    int descriptor_;
};

}  // namespace patchwright::occ
