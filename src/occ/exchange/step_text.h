// The text of a STEP file, made smaller without changing what it says.
#pragma once

#include <string>
#include <string_view>

namespace patchwright::occ {

/// Shares equal points, directions and straight p-curves with their contexts, leaves needless white
/// space away and numbers the instances anew, in order. Lines are at most 80 characters long but
/// for names.
/// @param text  a whole Part 21 file as the kernel writes it
/// Source: ISO 10303-21:2016, 5 (the basic alphabet, strings) and 9 (the data section).
std::string compact_step(std::string_view text);

/// Writes characters beyond ASCII as the `\X2\` and `\X4\` directives that Part 21 asks for.
/// @param text  UTF-8; bytes that are not are taken for Latin-1
/// Source: ISO 10303-21:2016, 6.4.3.
std::string encode_step_text(std::string_view text);

}  // namespace patchwright::occ
