#include "occ/guard/reader_server.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/guarded_read.h>

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <iterator>
#include <system_error>

namespace patchwright::occ {

namespace {

std::ptrdiff_t count_threads() {
    namespace fs = std::filesystem;
    return std::distance(fs::directory_iterator("/proc/self/task"), fs::directory_iterator());
}

}  // namespace

ReaderProcess::ReaderProcess() {
    if (count_threads() != 1)
        throw base::InvalidArgument("a reader process starts before there are threads");
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        throw std::system_error(errno, std::generic_category(), "a socket to read CAD files");
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

ReaderProcess::~ReaderProcess() {
    ::close(control_);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace patchwright::occ
