#include "base/pending_folders.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <list>
#include <new>

namespace patchwright::base {

namespace {

/// Longer than any rename or removal takes on a file system that answers.
constexpr std::chrono::milliseconds longest_hold{300};

using Folders = std::list<std::filesystem::path>;

Folders& pending_folders() {
    // Outlives all threads; made without memory, as it may be used up.
    alignas(Folders) static std::array<std::byte, sizeof(Folders)> place;
    static auto* const folders = new (place.data()) Folders;
    return *folders;
}

/// Allocates nothing, as memory may be used up.
void remove_with_content(int parent, const char* name) noexcept {
    const int folder = ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder >= 0) {
        alignas(dirent64) std::array<char, 4096> entries;
        for (;;) {
            const ssize_t size = ::getdents64(folder, entries.data(), entries.size());
            if (size <= 0) break;
            for (ssize_t at = 0; at < size;) {
                const auto* entry = reinterpret_cast<const dirent64*>(entries.data() + at);
                at += entry->d_reclen;
                const std::string_view file(entry->d_name);
                if (file == "." || file == "..") continue;
                if (::unlinkat(folder, entry->d_name, 0) != 0 && errno == EISDIR)
                    remove_with_content(folder, entry->d_name);
            }
        }
        ::close(folder);
    }
    ::unlinkat(parent, name, AT_REMOVEDIR);
}

}  // namespace

std::timed_mutex& pending_folders_mutex() {
    alignas(std::timed_mutex) static std::array<std::byte, sizeof(std::timed_mutex)> place;
    static auto* const mutex = new (place.data()) std::timed_mutex;
    return *mutex;
}

std::filesystem::path make_pending_folder(const std::filesystem::path& parent,
                                          const std::filesystem::path& given) {
    std::uint64_t number = 0;
    if (::getrandom(&number, sizeof number, 0) != ssize_t(sizeof number))
        throw OutputError(
            fmt::format("{}: no random name: {}", given.string(), std::strerror(errno)));
    std::filesystem::path folder = parent / fmt::format("{}{:016x}", pending_prefix, number);
    Folders entry{folder};
    std::unique_lock lock(pending_folders_mutex());
    if (::mkdir(folder.c_str(), 0700) != 0) {
        const int error = errno;
        lock.unlock();
        throw OutputError(fmt::format("{}: nothing can be written in its folder: {}",
                                      given.string(), std::strerror(error)));
    }
    pending_folders().splice(pending_folders().end(), entry);
    return folder;
}

void remove_pending_folder(const std::filesystem::path& folder) noexcept {
    const std::lock_guard lock(pending_folders_mutex());
    pending_folders().remove(folder);
    remove_with_content(AT_FDCWD, folder.c_str());
}

void abandon_pending_files() noexcept {
    if (!pending_folders_mutex().try_lock_for(longest_hold)) return;
    for (const std::filesystem::path& folder : pending_folders())
        remove_with_content(AT_FDCWD, folder.c_str());
    // The mutex stays locked.
}

}  // namespace patchwright::base
