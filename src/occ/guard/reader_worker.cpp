#include "occ/exchange/find_fault.h"
#include "occ/guard/messages.h"
#include "occ/guard/packed_result.h"
#include "occ/guard/reader_server.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <system_error>

namespace patchwright::occ {

namespace {

/// The kernel recurses over what is nested in a file; real files do with a tenth of this.
constexpr rlim_t stack_bytes = 64u << 20;
/// A fault so near to the end of the stack is one of the stack.
constexpr std::uintptr_t stack_margin = 1u << 20;
constexpr std::size_t handler_stack_bytes = 1u << 16;

std::uintptr_t stack_end = 0;

/// Lowers a limit, or raises it to what is allowed.
void set_limit(int resource, double value) {
    rlimit limit{};
    getrlimit(decltype(RLIMIT_AS)(resource), &limit);
    limit.rlim_cur = std::min(limit.rlim_max, rlim_t(std::max(value, 1.0)));
    setrlimit(decltype(RLIMIT_AS)(resource), &limit);
}

void limit_resources(const ReadRequest& request) {
    set_limit(RLIMIT_CPU, std::ceil(request.processor_s));
    set_limit(RLIMIT_STACK, stack_bytes);
    const rlimit no_core{};
    setrlimit(RLIMIT_CORE, &no_core);
#ifndef __SANITIZE_ADDRESS__  // which takes terabytes of address space for itself
    rlimit memory{};
    getrlimit(RLIMIT_AS, &memory);
    set_limit(RLIMIT_AS, std::min(request.memory_mb * 1e6, double(memory.rlim_cur)));
#endif
    // A write beyond the limit of file sizes is an error like others.
    std::signal(SIGXFSZ, SIG_IGN);
}

void on_segmentation_fault(int signal, siginfo_t* info, void*) {
    const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
    if (address + stack_margin > stack_end && address < stack_end + stack_margin)
        std::_Exit(stack_overflow_status);
    // The fault comes again, and ends the process as by default.
    std::signal(signal, SIG_DFL);
}

/// Tells endless recursion from other faults, on this thread.
void watch_stack() {
    static char handler_stack[handler_stack_bytes];
    rlimit limit{};
    getrlimit(RLIMIT_STACK, &limit);
    stack_end = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0)) - limit.rlim_cur;
    stack_t alternative{};
    alternative.ss_sp = handler_stack;
    alternative.ss_size = handler_stack_bytes;
    sigaltstack(&alternative, nullptr);
    struct sigaction action {};
    action.sa_sigaction = on_segmentation_fault;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    sigaction(SIGSEGV, &action, nullptr);
}

[[noreturn]] void on_memory_used_up() { std::_Exit(out_of_memory_status); }

void read(ReadRequest request, int channel) {
    if (request.task == ReadTask::FindFault) {
        find_fault(request.file, [channel](const std::string& entity) {
            send_message(channel, MessageKind::Entity, entity);
        });
        return;
    }
    request.options.progress = [channel, last = std::string()](std::string_view stage,
                                                               double fraction) mutable {
        const std::string text = fmt::format("{:.3f} {}", fraction, stage);
        if (text != last) send_message(channel, MessageKind::Progress, text);
        last = text;
        return true;
    };
    send_message(channel, MessageKind::Result,
                 pack_result(read_cad(request.file, request.options)));
}

}  // namespace

void read_in_worker(const ReadRequest& request, int channel) {
    limit_resources(request);
    watch_stack();
    std::set_new_handler(on_memory_used_up);
    try {
        base::set_thread_count(request.threads);
        read(request, channel);
    } catch (const base::InputError& error) {
        send_message(channel, MessageKind::Refusal, error.what());
    } catch (const std::bad_alloc&) {
        on_memory_used_up();
    } catch (const std::system_error& error) {
        send_message(channel, MessageKind::SystemError, std::to_string(error.code().value()));
    } catch (const std::exception& error) {
        send_message(channel, MessageKind::Failure, error.what());
    }
    // Nothing is worth being destroyed.
    std::_Exit(EXIT_SUCCESS);
}

}  // namespace patchwright::occ
