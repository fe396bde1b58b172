#include "occ/exchange/file_checks.h"
#include "occ/guard/messages.h"
#include "occ/guard/packed_result.h"
#include "occ/guard/read_request.h"
#include "occ/guard/reader_child.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/base/version.h>
#include <patchwright/occ/guarded_read.h>

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <optional>
#include <string>

namespace patchwright::occ {

namespace {

/// See ReaderProcess.
constexpr double base_s = 15.0, s_per_mb = 15.0;
constexpr double base_memory_mb = 2048.0, memory_mb_per_mb = 512.0;
/// For the second process, which looks for the entity that the first one ended at.
constexpr double fault_s = 5.0;
/// A person notices nothing shorter.
constexpr int poll_ms = 50;

/// How a reader process ended.
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

/// Runs the child, and passes on its progress.
class ReaderRun {
  public:
    ReaderRun(const ReaderProcess& reader, const ReadRequest& request)
        : reader_(reader), child_(reader.program, arguments_of(request)) {}

    /// Until there is a result, whose sender may take its time to end, or the child has ended.
    Ending finish(const base::Progress& progress) {
        std::string bytes;
        bool open = true;
        while (open && !ending_.result) {
            // Throws where the run is to stop; the child ends with this object.
            base::report_progress(progress, stage_, fraction_);
            open = child_.read_some(bytes, poll_ms);
            buffer_.append(bytes);
            bytes.clear();
            while (std::optional<Message> message = buffer_.next()) take(std::move(*message));
        }
        if (!ending_.result) ending_.status = child_.wait();
        if (!greeted_)
            throw base::Error(fmt::format("{}: is no reader of CAD files for patchwright {}",
                                          reader_.program.string(), base::version()));
        return std::move(ending_);
    }

  private:
    void take(Message message) {
        switch (message.kind) {
            case MessageKind::Hello: greeted_ = message.content == base::version(); break;
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

    const ReaderProcess& reader_;
    ReaderChild child_;
    MessageBuffer buffer_;
    Ending ending_;
    bool greeted_ = false;
    std::string stage_ = "read";
    double fraction_ = 0.0;
};

bool has_message(const Ending& ending, MessageKind kind) {
    return ending.last && ending.last->kind == kind;
}

bool ended_by(const Ending& ending, int signal) {
    return WIFSIGNALED(ending.status) && WTERMSIG(ending.status) == signal;
}

/// What happened to a child that left neither a result nor an error, and what to do.
std::string describe_end(const Ending& ending, const ReadRequest& request,
                         const std::string& entity) {
    const std::string at = entity.empty() ? "" : " on " + entity;
    if (has_message(ending, MessageKind::OutOfMemory))
        return fmt::format("the CAD kernel needs more than {:.0f} MB of memory{}; repair the file",
                           request.memory_mb, at);
    if (ended_by(ending, SIGXCPU))
        return fmt::format(
            "the CAD kernel has not read it within {:.0f} s of processor time{}; repair the file, "
            "or pass a larger --read-limit if it is merely large",
            request.processor_s, at);
    if (has_message(ending, MessageKind::StackOverflow))
        return fmt::format("the CAD kernel falls into endless recursion{}; repair the file", at);
    if (ended_by(ending, SIGKILL))
        return "the system has ended the process that read it; is the memory full?";
    const char* signal =
        WIFSIGNALED(ending.status) ? sigabbrev_np(WTERMSIG(ending.status)) : nullptr;
    return fmt::format("the CAD kernel crashes{}{}; repair the file", at,
                       signal != nullptr ? fmt::format(" (SIG{})", signal) : "");
}

/// The entity that the kernel fails at when it is given each by itself; empty where none is.
std::string find_entity(const ReaderProcess& reader, ReadRequest request,
                        const base::Progress& progress) {
    request.task = ReadTask::FindFault;
    request.processor_s = fault_s;
    return ReaderRun(reader, request).finish(progress).entity;
}

}  // namespace

ReadResult read_cad_guarded(const std::filesystem::path& path, const ReaderProcess& reader,
                            const ReadOptions& options) {
    const double mb = size_mb(path);
    ReadRequest request{
        .file = path,
        .options = options,
        .threads = base::thread_count(),
        .processor_s = reader.time_limit_s.value_or(base_s + s_per_mb * mb),
        .memory_mb = reader.memory_limit_mb.value_or(base_memory_mb + memory_mb_per_mb * mb),
        .parent = ::getpid()};
    ReaderRun run(reader, request);
    Ending ending = run.finish(options.progress);
    if (ending.result) return unpack_result(std::move(*ending.result));
    if (has_message(ending, MessageKind::Refusal)) throw base::InputError(ending.last->content);
    if (has_message(ending, MessageKind::Failure)) throw base::Error(ending.last->content);
    refuse(path, "{}",
           describe_end(ending, request, find_entity(reader, request, options.progress)));
}

}  // namespace patchwright::occ
