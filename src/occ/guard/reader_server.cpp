#include "occ/guard/reader_server.h"

#include "occ/guard/job_socket.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdlib>

namespace patchwright::occ {

namespace {

/// The parent may have ended before it could be asked to take this process with it.
void end_with(pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(EXIT_FAILURE);
}

/// Nothing but the socket is shared with the parent: signals are handled as by default, what a
/// terminal sends is for the parent to judge, and standard streams lead nowhere.
void cut_loose(int control) {
    ::setpgid(0, 0);
    for (int signal = 1; signal < NSIG; ++signal) std::signal(signal, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
    ::close_range(STDERR_FILENO + 1, unsigned(control) - 1, 0);
    ::close_range(unsigned(control) + 1, UINT_MAX, 0);
}

/// Kills the worker when nobody listens to it any more.
/// @param life  the worker has the other end of this pipe
/// @return as waitpid() tells it
int wait_for(pid_t worker, int channel, int life) {
    std::array<pollfd, 2> ends{{{channel, 0, 0}, {life, 0, 0}}};
    while (::poll(ends.data(), ends.size(), -1) < 0 && errno == EINTR) {
    }
    if (ends[0].revents != 0) ::kill(worker, SIGKILL);
    int status = 0;
    while (::waitpid(worker, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

/// @return see send_status()
int carry_out(const Job& job) {
    std::array<int, 2> life{};
    if (::pipe2(life.data(), O_CLOEXEC) != 0) return -errno;
    const pid_t server = ::getpid();
    const pid_t worker = ::fork();
    if (worker == 0) {
        ::close(life[0]);
        end_with(server);
        read_in_worker(unpack_request(job.request), job.channel);
    }
    const int error = errno;
    ::close(life[1]);
    const int status = worker < 0 ? -error : wait_for(worker, job.channel, life[0]);
    ::close(life[0]);
    return status;
}

}  // namespace

void serve_reads(int control, std::optional<pid_t> parent) {
    if (parent) end_with(*parent);
    cut_loose(control);
    while (const std::optional<Job> job = receive_job(control)) {
        const int status = carry_out(*job);
        ::close(job->channel);
        if (!send_status(control, status)) break;
    }
    std::_Exit(EXIT_SUCCESS);
}

}  // namespace patchwright::occ
