// Text within XML and HTML.
#pragma once

#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// The text with the characters that mean something in markup replaced by entities: & < > ".
std::string escape_markup(std::string_view text);

}  // namespace patchwright::base
#pragma GCC visibility pop
