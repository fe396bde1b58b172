#include "occ/guard/reader_server.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/guarded_read.h>

#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>

namespace patchwright::occ {

namespace {

std::ptrdiff_t count_threads() {
    namespace fs = std::filesystem;
    return std::distance(fs::directory_iterator("/proc/self/task"), fs::directory_iterator());
}

/// This process's end of the socket first.
std::array<int, 2> make_control() {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        throw std::system_error(errno, std::generic_category(), "a socket to read CAD files");
    return ends;
}

/// The program's end of the socket. It would end with the thread that starts it if it asked the
/// system to: it does not, and ends with the socket.
constexpr int program_control = 3;

/// Starts the program with this socket.
/// @return 0, or errno
int spawn(const std::string& program, int control, pid_t& process) {
    posix_spawn_file_actions_t actions;
    if (const int error = ::posix_spawn_file_actions_init(&actions)) return error;
    // Onto itself too: that takes its close-on-exec away.
    int error = ::posix_spawn_file_actions_adddup2(&actions, control, program_control);
    std::string name = program;
    std::array<char*, 2> arguments{name.data(), nullptr};
    if (error == 0)
        error =
            ::posix_spawn(&process, program.c_str(), &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    return error;
}

}  // namespace

ReaderProcess::ReaderProcess() {
    if (count_threads() != 1)
        throw base::InvalidArgument("a reader process starts before there are threads");
    const std::array<int, 2> ends = make_control();
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ == 0) serve_reads(ends[1], parent);
    const int error = errno;
    ::close(ends[1]);
    control_ = ends[0];
    if (process_ > 0) return;
    ::close(control_);
    throw std::system_error(error, std::generic_category(), "a process to read CAD files");
}

ReaderProcess::ReaderProcess(const std::filesystem::path& program) {
    const std::array<int, 2> ends = make_control();
    const int error = spawn(program.string(), ends[1], process_);
    ::close(ends[1]);
    control_ = ends[0];
    if (error == 0) return;
    ::close(control_);
    throw std::system_error(error, std::generic_category(), program.string());
}

int run_reader(int argc, char** argv) {
    struct stat control {};
    if (argc != 1 || ::fstat(program_control, &control) != 0 || !S_ISSOCK(control.st_mode)) {
        std::fprintf(stderr, "%s: patchwright starts this program to read CAD files\n",
                     argc > 0 ? argv[0] : "");
        return EXIT_FAILURE;
    }
    serve_reads(program_control, std::nullopt);
}

ReaderProcess::~ReaderProcess() {
    ::close(control_);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace patchwright::occ
