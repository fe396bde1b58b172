// The C library's allocation with the new-handler of C++, which signals.h sets: libraries in C
// (HDF5, CGNS, the scanner of STEP files) crash, end the process or report a full disk where they
// get no memory. Before main(), libraries have no such handler and no memory for an exception.
// Operator new, for which malloc() works here, and the CAD kernel throw where that is to be caught.
#include "signals.h"

#include <patchwright/base/memory.h>

#include <cstddef>
#include <new>

#ifndef __SANITIZE_ADDRESS__  // which has an allocation of its own

namespace {

void* checked(void* memory, bool is_needed) noexcept {
    const bool ends = is_needed && !patchwright::base::MayRunOutOfMemory::is_under_way();
    if (memory == nullptr && ends) {
        if (const std::new_handler handler = std::get_new_handler()) handler();
        patchwright::cli::end_without_memory();
    }
    return memory;
}

}  // namespace

extern "C" {

// Of the GNU C library, which calls the functions below in their place.
void* __libc_malloc(std::size_t) noexcept;
void* __libc_calloc(std::size_t, std::size_t) noexcept;
void* __libc_realloc(void*, std::size_t) noexcept;

void* malloc(std::size_t bytes) noexcept { return checked(__libc_malloc(bytes), true); }
void* calloc(std::size_t count, std::size_t bytes) noexcept {
    return checked(__libc_calloc(count, bytes), true);
}
void* realloc(void* memory, std::size_t bytes) noexcept {
    return checked(__libc_realloc(memory, bytes), bytes > 0);
}
}

#endif
