// Reading CAD files in a process of its own, which the kernel may bring down.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::occ {

/// A copy of this process from before it had threads, or a program, which makes a copy of itself
/// for each file.
class ReaderProcess {
  public:
    /// For the first lines of main().
    /// @pre this process has one thread: a copy has no others, but all the locks they hold
    /// @throw InvalidArgument when it has more
    /// @throw std::system_error when the system gives no process
    ReaderProcess();
    /// For processes that have threads, such as an interpreter's: starts a program of the same
    /// build in place of a copy, whose main() is run_reader().
    /// @throw std::system_error when it cannot be started
    explicit ReaderProcess(const std::filesystem::path& program);
    ~ReaderProcess();
    ReaderProcess(const ReaderProcess&) = delete;
    ReaderProcess& operator=(const ReaderProcess&) = delete;

  private:
    friend class ReaderRun;
    std::mutex mutex_;  ///< held while a file is read
    int control_ = -1;
    int process_ = -1;
};

/// What a program for ReaderProcess does.
/// @param argc, argv  of main()
/// @return its exit status, where it was not started by a ReaderProcess
int run_reader(int argc, char** argv);

/// What of the machine reading may take.
struct ReadLimits {
    /// Of processor time; none: 15 and 15 for each MB of the file, ten times what any known file
    /// takes.
    std::optional<double> time_s;
    /// Of address space; none: 2048 and 512 for each MB of the file, twenty times what any known
    /// file takes.
    std::optional<double> memory_mb;
};

/// The same as read_cad(), but the kernel works in another process, which ends with this one.
/// Waits while another thread reads.
/// @throw InputError as read_cad(); also when the kernel crashes, recurses without end or exceeds a
///        limit, with the entity that it was at where that is known
/// @throw Cancelled or TimeLimitReached from the progress callback; nothing is being read then
/// @throw std::bad_alloc when this process may have less memory than the limit, and it is used up
/// @throw std::system_error when the system gives no process or ends it
ReadResult read_cad_guarded(const std::filesystem::path& path, ReaderProcess& reader,
                            const ReadOptions& options = {}, const ReadLimits& limits = {});

}  // namespace patchwright::occ
#pragma GCC visibility pop
