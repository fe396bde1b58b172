// Errors of input that name the file they are about.
#pragma once

#include <patchwright/base/error.h>

#include <string>
#include <utility>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Calls `body`; errors of input that do not name `input` are said to be of it.
template <class Body>
auto about_input(const std::string& input, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const InputError& error) {
        const std::string text = error.what();
        throw InputError(text.find(input) == std::string::npos ? input + ": " + text : text);
    }
}

}  // namespace patchwright::base
#pragma GCC visibility pop
