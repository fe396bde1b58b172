#include "signals.h"

#include "command.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>
#include <patchwright/base/output_set.h>

#include <fmt/format.h>
#include <pthread.h>
#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>
#include <thread>

namespace patchwright::cli {

namespace {

/// Stages that poll end within this; it leaves half a second of the two that a stop may take.
constexpr std::chrono::milliseconds longest_unwinding{1500};

std::atomic<int> first_signal = 0;
std::atomic<int> finished_with = -1;  // an exit code
std::atomic<bool> has_said = false, is_ending = false;
sem_t signal_arrived;

/// Allocates nothing.
void print_line(std::string_view text) noexcept {
    // Over a line of progress.
    const std::string_view start = ::isatty(STDERR_FILENO) != 0 ? "\r\033[K" : "";
    for (const std::string_view part :
         {start, std::string_view("patchwright: "), text, std::string_view("\n")}) {
        if (::write(STDERR_FILENO, part.data(), part.size()) < 0) return;
    }
}

/// Ends the process without unwinding; threads may be anywhere. Allocates nothing. The first thread
/// to come here decides.
[[noreturn]] void end_now(int exit_code, const char* text) noexcept {
    thread_local bool is_here = false;
    if (is_here) ::_exit(exit_code);
    is_here = true;
    while (is_ending.exchange(true)) ::pause();
    base::abandon_pending_files();
    if (!has_said.exchange(true)) print_line(text);
    ::_exit(exit_code);
}

const char* text_of(int signal) noexcept {
    switch (signal) {
        case SIGINT: return "interrupted; no file was written or changed";
        case SIGTERM: return "terminated; no file was written or changed";
        case SIGHUP: return "the terminal hung up; no file was written or changed";
        case SIGXFSZ:
            return "a file grew beyond the limit of file sizes (ulimit -f); no file was written or "
                   "changed";
        case SIGPIPE:
            return "nothing reads the output any more (broken pipe); no file was written or "
                   "changed";
        default: return "stopped by a signal; no file was written or changed";
    }
}

extern "C" void on_signal(int signal) {
    const int before = errno;
    int none = 0;
    if (first_signal.compare_exchange_strong(none, signal)) ::sem_post(&signal_arrived);
    errno = before;
}

extern "C" void* end_what_does_not_stop(void*) {
    while (::sem_wait(&signal_arrived) != 0) {
    }
    std::this_thread::sleep_for(longest_unwinding);
    const int code = finished_with;
    if (code >= 0) ::_exit(code);
    end_now(exit_code_of(first_signal), text_of(first_signal));
}

[[noreturn]] void on_terminate() {
    try {
        if (std::current_exception()) std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc&) {
        end_now(InternalError, out_of_memory);
    } catch (const std::exception& error) {
        if (!has_said.exchange(true)) {
            print_line("internal error, please report:");
            print_line(error.what());
        }
    } catch (...) {
    }
    end_now(InternalError, "internal error, please report: an error of an unknown kind");
}

void on_memory_used_up() {
    if (base::MayRunOutOfMemory::is_under_way()) throw std::bad_alloc();
    end_without_memory();
}

void start_watching() {
    ::sem_init(&signal_arrived, 0, 0);
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, 4 * std::size_t(PTHREAD_STACK_MIN));
    pthread_t thread{};
    const int error = ::pthread_create(&thread, &attributes, end_what_does_not_stop, nullptr);
    if (error != 0) throw std::system_error(error, std::generic_category(), "a thread");
    ::pthread_detach(thread);
}

}  // namespace

void end_without_memory() noexcept { end_now(InternalError, out_of_memory); }

void catch_signals() {
    std::set_terminate(on_terminate);
    std::set_new_handler(on_memory_used_up);
    start_watching();
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXFSZ, SIGPIPE}) {
        struct sigaction action {};
        ::sigaction(signal, nullptr, &action);
        if (action.sa_handler == SIG_IGN) continue;  // by nohup, say
        action = {};
        action.sa_handler = on_signal;
        action.sa_flags = SA_RESTART;
        ::sigaction(signal, &action, nullptr);
    }
}

int stop_signal() { return first_signal; }

void stop_if_asked() {
    if (stop_signal() != 0) throw base::Cancelled();
}

int exit_code_of(int signal) { return 128 + signal; }

std::string message_of(int signal) { return text_of(signal); }

void outputs_are_in_place(int exit_code) { finished_with = exit_code; }

void say_last_line(const std::string& text) noexcept {
    if (!has_said.exchange(true)) print_line(text);
}

}  // namespace patchwright::cli
