#include "occ/exchange/file_checks.h"
#include "occ/guard/job_socket.h"
#include "occ/guard/messages.h"
#include "occ/guard/packed_result.h"
#include "occ/guard/reader_server.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/guarded_read.h>

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace patchwright::occ {

namespace {

/// See ReadLimits.
constexpr double base_s = 15.0, s_per_mb = 15.0;
constexpr double base_memory_mb = 2048.0, memory_mb_per_mb = 512.0;
/// For the second worker, which looks for the entity that the first one ended at.
constexpr double fault_s = 5.0;
/// A person notices nothing shorter.
constexpr int poll_ms = 50;

/// How a worker ended.
struct Ending {
    std::optional<std::string> result;  ///< packed
    std::optional<Message> last;        ///< what it says about its end
    std::string entity;                 ///< the last that it was at
    int status = 0;                     ///< as waitpid() tells it
};

double size_mb(const std::filesystem::path& file) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(file, error);
    return error ? 0.0 : double(bytes) / 1e6;
}

[[noreturn]] void refuse_by_system(int error) {
    throw std::system_error(error, std::generic_category(), "reading a CAD file");
}

}  // namespace

/// One job of a reader, whose progress it passes on. Ends it when it is destroyed before.
class ReaderRun {
  public:
    ReaderRun(ReaderProcess& reader, const ReadRequest& request)
        : lock_(reader.mutex_), control_(reader.control_) {
        std::array<int, 2> ends{};
        if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
            refuse_by_system(errno);
        const bool is_taken = send_job(control_, {pack_request(request), ends[1]});
        ::close(ends[1]);
        channel_ = ends[0];
        if (is_taken) return;
        ::close(channel_);
        refuse_by_system(ESRCH);
    }
    ~ReaderRun() {
        if (channel_ >= 0) wait();
    }
    ReaderRun(const ReaderRun&) = delete;
    ReaderRun& operator=(const ReaderRun&) = delete;

    /// Until there is a result, or the worker has ended.
    Ending finish(const base::Progress& progress) {
        bool open = true;
        while (open && !ending_.result) {
            base::report_progress(progress, stage_, fraction_);
            open = read_some();
            while (std::optional<Message> message = buffer_.next()) take(std::move(*message));
        }
        if (ending_.result) return std::move(ending_);
        const std::optional<int> status = wait();
        if (!status) refuse_by_system(ESRCH);
        if (*status < 0) refuse_by_system(-*status);
        ending_.status = *status;
        return std::move(ending_);
    }

  private:
    /// @return false when the worker has closed its end
    bool read_some() {
        pollfd waiting{channel_, POLLIN, 0};
        if (::poll(&waiting, 1, poll_ms) <= 0) return true;
        const ssize_t count = ::recv(channel_, block_.data(), block_.size(), 0);
        if (count > 0) buffer_.append({block_.data(), std::size_t(count)});
        return count > 0 || (count < 0 && errno == EINTR);
    }
    /// Listens no more, and waits for the worker's end.
    std::optional<int> wait() {
        ::close(std::exchange(channel_, -1));
        return receive_status(control_);
    }
    void take(Message message) {
        switch (message.kind) {
            case MessageKind::Entity: ending_.entity = std::move(message.content); break;
            case MessageKind::Progress: {
                const std::string& text = message.content;
                const auto end =
                    std::from_chars(text.data(), text.data() + text.size(), fraction_).ptr;
                stage_ = std::string(end, text.data() + text.size()).substr(1);
                break;
            }
            case MessageKind::Result: ending_.result = std::move(message.content); break;
            default: ending_.last = std::move(message);
        }
    }

    std::lock_guard<std::mutex> lock_;
    int control_, channel_ = -1;
    std::array<char, 1 << 18> block_;  // what a socket holds
    MessageBuffer buffer_;
    Ending ending_;
    std::string stage_ = "read";
    double fraction_ = 0.0;
};

namespace {

bool has_message(const Ending& ending, MessageKind kind) {
    return ending.last && ending.last->kind == kind;
}

bool exited_with(const Ending& ending, int status) {
    return WIFEXITED(ending.status) && WEXITSTATUS(ending.status) == status;
}

bool ended_by(const Ending& ending, int signal) {
    return WIFSIGNALED(ending.status) && WTERMSIG(ending.status) == signal;
}

/// What happened to a worker that left neither a result nor an error, and what to do.
std::string describe_end(const Ending& ending, const ReadRequest& request,
                         const std::string& entity) {
    const std::string at = entity.empty() ? "" : " on " + entity;
    if (exited_with(ending, out_of_memory_status))
        return fmt::format("the CAD kernel needs more than {:.0f} MB of memory{}; repair the file",
                           request.memory_mb, at);
    if (ended_by(ending, SIGXCPU))
        return fmt::format(
            "the CAD kernel has not read it within {:.0f} s of processor time{}; repair the file, "
            "or pass a larger --read-limit if it is merely large",
            request.processor_s, at);
    if (exited_with(ending, stack_overflow_status))
        return fmt::format("the CAD kernel falls into endless recursion{}; repair the file", at);
    const char* signal =
        WIFSIGNALED(ending.status) ? sigabbrev_np(WTERMSIG(ending.status)) : nullptr;
    return fmt::format("the CAD kernel crashes{}{}; repair the file", at,
                       signal != nullptr ? fmt::format(" (SIG{})", signal) : "");
}

/// The entity that the kernel fails at when it is given each by itself; empty where none is.
std::string find_entity(ReaderProcess& reader, ReadRequest request,
                        const base::Progress& progress) {
    request.task = ReadTask::FindFault;
    request.processor_s = fault_s;
    return ReaderRun(reader, request).finish(progress).entity;
}

/// Throws what is no fault of the file.
void check_system(const Ending& ending, const ReadRequest& request) {
    if (has_message(ending, MessageKind::Failure)) throw base::Error(ending.last->content);
    if (has_message(ending, MessageKind::SystemError))
        refuse_by_system(std::atoi(ending.last->content.c_str()));
    if (exited_with(ending, out_of_memory_status) && base::memory_bytes() < request.memory_mb * 1e6)
        throw std::bad_alloc();
    // By a person, or by the system when the machine has no memory left.
    if (ended_by(ending, SIGKILL)) refuse_by_system(ENOMEM);
}

}  // namespace

ReadResult read_cad_guarded(const std::filesystem::path& path, ReaderProcess& reader,
                            const ReadOptions& options, const ReadLimits& limits) {
    const double mb = size_mb(path);
    const ReadRequest request{
        .file = path,
        .options = options,
        .threads = base::thread_count(),
        .processor_s = limits.time_s.value_or(base_s + s_per_mb * mb),
        .memory_mb = limits.memory_mb.value_or(base_memory_mb + memory_mb_per_mb * mb)};
    std::optional<ReaderRun> run(std::in_place, reader, request);
    Ending ending = run->finish(options.progress);
    if (ending.result) return unpack_result(std::move(*ending.result), path.string());
    run.reset();
    check_system(ending, request);
    if (has_message(ending, MessageKind::Refusal)) throw base::InputError(ending.last->content);
    refuse(path, "{}",
           describe_end(ending, request, find_entity(reader, request, options.progress)));
}

}  // namespace patchwright::occ
