// A child process that writes to a pipe.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace patchwright::occ {

/// The descriptor that the child writes its messages to.
constexpr int message_descriptor = 3;

/// Starts a program, which is killed when this object ends before it.
class ReaderChild {
  public:
    /// Standard input and outputs lead nowhere; signals are handled as by default. The child is a
    /// process group of its own: what a terminal sends is for the parent to judge.
    /// @throw Error when the program cannot be started
    ReaderChild(const std::filesystem::path& program, const std::vector<std::string>& arguments);
    ~ReaderChild();
    ReaderChild(const ReaderChild&) = delete;
    ReaderChild& operator=(const ReaderChild&) = delete;

    /// Waits at most so long for bytes, and appends them.
    /// @return false when the child has closed its end
    bool read_some(std::string& bytes, int timeout_ms);

    /// Waits for the end.
    /// @return as waitpid() tells it
    int wait();

  private:
    int output_ = -1;
    pid_t process_ = -1;
};

}  // namespace patchwright::occ
