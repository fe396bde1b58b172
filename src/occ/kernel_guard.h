// Kernel exceptions never leave the room: Standard_Failure is not a std::exception.
#pragma once

#include <patchwright/base/error.h>

#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>

#include <algorithm>
#include <new>
#include <string>
#include <utility>

namespace patchwright::occ {

/// Calls `body`; a kernel exception becomes an `ErrorType` whose message starts with `context`, or
/// std::bad_alloc where memory is used up.
template <class ErrorType, class Body>
auto guard_kernel(const std::string& context, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const Standard_OutOfMemory&) {
        throw std::bad_alloc();
    } catch (const Standard_Failure& failure) {
        const char* text = failure.GetMessageString();
        std::string message = context + ": CAD kernel: " + failure.DynamicType()->Name() +
                              (text != nullptr && *text != '\0' ? std::string(": ") + text : "");
        std::replace(message.begin(), message.end(), '\n', ' ');
        throw ErrorType(message);
    }
}

}  // namespace patchwright::occ
