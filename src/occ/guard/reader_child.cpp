#include "occ/guard/reader_child.h"

#include <patchwright/base/error.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

namespace patchwright::occ {

namespace {

/// What happens between the two programs, by the system: no code of ours runs in a copy of a
/// process that may have threads.
class SpawnSettings {
  public:
    explicit SpawnSettings(int output) {
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_adddup2(&files, output, message_descriptor);
        for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
            posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);
        posix_spawnattr_init(&attributes);
        sigset_t none, all;
        sigemptyset(&none);
        sigfillset(&all);
        posix_spawnattr_setsigmask(&attributes, &none);
        posix_spawnattr_setsigdefault(&attributes, &all);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(
            &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    }
    ~SpawnSettings() {
        posix_spawn_file_actions_destroy(&files);
        posix_spawnattr_destroy(&attributes);
    }
    SpawnSettings(const SpawnSettings&) = delete;
    SpawnSettings& operator=(const SpawnSettings&) = delete;

    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
};

}  // namespace

ReaderChild::ReaderChild(const std::filesystem::path& program,
                         const std::vector<std::string>& arguments) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw base::Error(fmt::format("no pipe to a reader process: {}", std::strerror(errno)));
    std::string name = program.string();
    std::vector<char*> words{name.data()};
    std::vector<std::string> copies = arguments;
    for (std::string& word : copies) words.push_back(word.data());
    words.push_back(nullptr);
    const SpawnSettings settings(ends[1]);
    const int error = ::posix_spawn(&process_, program.c_str(), &settings.files,
                                    &settings.attributes, words.data(), environ);
    ::close(ends[1]);
    output_ = ends[0];
    if (error == 0) return;
    ::close(output_);
    throw base::Error(fmt::format("{}: the program that reads CAD files cannot be started: {}",
                                  name, std::strerror(error)));
}

ReaderChild::~ReaderChild() {
    ::close(output_);
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    wait();
}

bool ReaderChild::read_some(std::string& bytes, int timeout_ms) {
    pollfd waiting{output_, POLLIN, 0};
    if (::poll(&waiting, 1, timeout_ms) <= 0) return true;
    std::array<char, 1 << 16> block;  // what a pipe holds
    const ssize_t count = ::read(output_, block.data(), block.size());
    if (count > 0) bytes.append(block.data(), std::size_t(count));
    return count > 0 || (count < 0 && errno == EINTR);
}

int ReaderChild::wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
}

}  // namespace patchwright::occ
