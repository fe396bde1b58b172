#include <patchwright/base/memory.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>

namespace patchwright::base {

namespace {

std::atomic<int> works_that_may_run_out = 0;

}  // namespace

double memory_bytes() {
    const double machine = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return machine;
    return std::min(machine, double(limit.rlim_cur));
}

MayRunOutOfMemory::MayRunOutOfMemory() noexcept { ++works_that_may_run_out; }

MayRunOutOfMemory::~MayRunOutOfMemory() { --works_that_may_run_out; }

bool MayRunOutOfMemory::is_under_way() noexcept { return works_that_may_run_out > 0; }

}  // namespace patchwright::base
