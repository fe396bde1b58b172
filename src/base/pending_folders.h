// The folders of all pending files of the process, so that they can be removed before it ends.
#pragma once

#include <filesystem>
#include <mutex>
#include <string_view>

namespace patchwright::base {

/// Held while folders are made, removed, or their files renamed; nothing is allocated meanwhile, as
/// a process whose memory is used up takes it to remove them.
std::timed_mutex& pending_folders_mutex();

/// Makes a folder that only this user may enter, and remembers it.
/// @param given  what messages name
/// @throw OutputError
std::filesystem::path make_pending_folder(const std::filesystem::path& parent,
                                          const std::filesystem::path& given);
void remove_pending_folder(const std::filesystem::path& folder) noexcept;

}  // namespace patchwright::base
