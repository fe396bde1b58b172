// Checks of options' values, made while the command line is parsed.
#pragma once

#include <CLI/CLI.hpp>

namespace patchwright::cli {

/// A finite number between these, both allowed.
CLI::Validator number_in(double least, double most);
/// A finite number above 0, up to `most`.
CLI::Validator positive_up_to(double most);
/// "0.05mm", "1e-4rel"; see base::parse_length.
CLI::Validator is_length();
CLI::Validator is_angle();
/// "mm", "cm", "m", "in", "ft".
CLI::Validator is_unit();
/// The same, or "input".
CLI::Validator is_unit_or_input();
CLI::Validator is_not_empty();

}  // namespace patchwright::cli
