#include "occ/exchange/memory_file.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace patchwright::occ {

MemoryFile::MemoryFile(std::string_view content)
    : descriptor_(::memfd_create("patchwright", MFD_CLOEXEC)) {
    while (descriptor_ >= 0 && !content.empty()) {
        const ssize_t written = ::write(descriptor_, content.data(), content.size());
        if (written <= 0) break;
        content.remove_prefix(std::size_t(written));
    }
    if (descriptor_ >= 0 && content.empty()) return;
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw std::system_error(error, std::generic_category(), "a repaired copy of the input");
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

std::filesystem::path MemoryFile::path() const {
    return fmt::format("/proc/self/fd/{}", descriptor_);
}

}  // namespace patchwright::occ
