// The text of a STEP file, made smaller without changing what it says.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

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

/// By number: the text behind '=' without white space and comments.
using StepInstances = std::map<int, std::string>;

/// Those of the numbers asked for that a whole Part 21 file has.
StepInstances step_instances(std::string_view text, const std::set<int>& numbers);

/// The numbers an instance refers to, in order.
std::vector<int> step_references(std::string_view instance);

/// "ADVANCED_FACE"; the parts of a complex instance are joined by '+'.
std::string step_type(std::string_view instance);

}  // namespace patchwright::occ
