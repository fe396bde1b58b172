// How much memory there is to work with, and what happens where it is used up.
#pragma once

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Bytes that this process may have at most: the machine's memory, or its limit of addresses where
/// that is less.
double memory_bytes();

/// While one exists, work is under way that may run out of memory without loss: its caller catches
/// std::bad_alloc. New-handlers that end the process otherwise are to throw it then.
class MayRunOutOfMemory {
  public:
    MayRunOutOfMemory() noexcept;
    ~MayRunOutOfMemory();
    MayRunOutOfMemory(const MayRunOutOfMemory&) = delete;
    MayRunOutOfMemory& operator=(const MayRunOutOfMemory&) = delete;

    /// On any thread; allocates nothing.
    [[nodiscard]] static bool is_under_way() noexcept;
};

}  // namespace patchwright::base
#pragma GCC visibility pop
