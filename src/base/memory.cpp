#include <patchwright/base/memory.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace patchwright::base {

double memory_bytes() {
    const double machine = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return machine;
    return std::min(machine, double(limit.rlim_cur));
}

}  // namespace patchwright::base
