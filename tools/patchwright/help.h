// What the command line says about itself: help, manual page, completions, advice on wrong names.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace patchwright::cli {

/// Puts the options of all subcommands into groups, names their values, and adds examples.
void describe_commands(CLI::App& app);

/// `help [COMMAND]`, `completion SHELL` and `man`. Call after all others are there.
void register_help(CLI::App& app);

/// @throw UsageError for a subcommand or an option that does not exist, with the one whose name is
///        nearest
void check_names(const CLI::App& app, const std::vector<std::string>& arguments);

/// @param text  what the parser says of a file with options
/// @throw UsageError that names the option and what is wrong with it
[[noreturn]] void refuse_config(const CLI::App& app, const std::string& text);

/// Script for a shell: bash, zsh or fish.
std::string completion(const CLI::App& app, const std::string& shell);

/// Source of the manual page, in the macros of man(7).
std::string manual(const CLI::App& app);

/// Words that an option's value is one of; empty where it is anything else.
std::vector<std::string> choices(const CLI::Option& option);
/// Whether an option's value is the name of a file.
bool takes_file(const CLI::Option& option);

}  // namespace patchwright::cli
