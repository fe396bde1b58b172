// The global section of IGES files as text: what the kernel's defaults hide.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace patchwright::occ {

/// Parameter and record delimiter as the global section sets them, by default ",;".
std::string iges_delimiters(std::string_view text);

/// The parameters of the global section without surrounding blanks, strings with their "5H"; empty
/// where a default is meant. Number 1 comes first.
/// @param text  a file in fixed form
/// Source: IGES 5.3, 2.2.2 (constants) and 2.2.4.3 (global section).
std::vector<std::string> iges_global_parameters(std::string_view text);

}  // namespace patchwright::occ
