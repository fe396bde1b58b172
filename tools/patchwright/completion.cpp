#include "help.h"

#include <patchwright/base/error.h>
#include <patchwright/base/version.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::cli {

namespace {

/// With each of the characters after a backslash.
std::string escaped(const std::string& text, const std::string& characters) {
    std::string result;
    for (const char c : text) {
        if (characters.find(c) != std::string::npos) result += '\\';
        result += c;
    }
    return result;
}

/// As one word of a shell that takes all between single quotes as it is.
std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// Options with names, not positional ones; of a subcommand also the program's, which it takes.
std::vector<const CLI::Option*> named_options(const CLI::App& command) {
    const auto is_named = [](const CLI::Option* option) { return !option->get_positional(); };
    std::vector<const CLI::Option*> options = command.get_options(is_named);
    if (command.get_parent() == nullptr) return options;
    for (const CLI::Option* option : command.get_parent()->get_options(is_named))
        if (command.get_option_no_throw("--" + option->get_lnames().front()) == nullptr)
            options.push_back(option);
    return options;
}

std::vector<std::string> all_names(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string bash(const CLI::App& app) {
    std::string commands, words, values;
    for (const CLI::App* command : app.get_subcommands({})) {
        commands += command->get_name() + " ";
        std::string names;
        for (const CLI::Option* option : named_options(*command)) {
            names += fmt::format("{} ", fmt::join(all_names(*option), " "));
            if (const auto all = choices(*option); !all.empty())
                values += fmt::format("        {}:{}) words=\"{}\" ;;\n", command->get_name(),
                                      all_names(*option).back(), fmt::join(all, " "));
            else if (takes_value(*option) && !takes_file(*option))
                values += fmt::format(
                    "        {}:{}) return ;;\n", command->get_name(),
                    fmt::join(all_names(*option), fmt::format("|{}:", command->get_name())));
        }
        words += fmt::format("        {}) words=\"{}\" ;;\n", command->get_name(), names);
    }
    return fmt::format(R"(_patchwright() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} words=
    if ((COMP_CWORD == 1)); then
        COMPREPLY=($(compgen -W "{0}--help --version --config" -- "$current"))
        return
    fi
    COMPREPLY=()
    case ${{COMP_WORDS[1]}}:$before in
        help:*) words="{0}" ;;
        completion:*) words="bash zsh fish" ;;
{2}    esac
    [[ $words || $current != -* ]] || case ${{COMP_WORDS[1]}} in
{1}    esac
    if [[ $words ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$current"))
    else
        COMPREPLY=($(compgen -f -- "$current"))
    fi
}}
complete -o filenames -F _patchwright patchwright
)",
                       commands, words, values);
}

std::string zsh_option(const CLI::Option& option) {
    const std::string help = escaped(option.get_description(), "[]:\\");
    std::string value;
    if (takes_value(option)) {
        const auto all = choices(option);
        value = takes_file(option) ? ":value:_files"
                : all.empty()      ? ":value: "
                                   : fmt::format(":value:({})", fmt::join(all, " "));
    }
    std::string text;
    for (const std::string& name : all_names(option))
        text += " \\\n                " + quoted(fmt::format("{}[{}]{}", name, help, value));
    return text;
}

std::string zsh(const CLI::App& app) {
    std::string commands, cases;
    for (const CLI::App* command : app.get_subcommands({})) {
        commands += fmt::format("        {}\n",
                                quoted(command->get_name() + ":" + command->get_description()));
        cases += fmt::format("            {})\n                _arguments", command->get_name());
        for (const CLI::Option* option : named_options(*command)) cases += zsh_option(*option);
        cases += " \\\n                '*:file:_files' ;;\n";
    }
    return fmt::format(R"(#compdef patchwright
_patchwright() {{
    local -a commands=(
{0}    )
    if ((CURRENT == 2)); then
        _describe command commands
    else
        case $words[2] in
{1}        esac
    fi
}}
if [[ $funcstack[1] == _patchwright ]]; then
    _patchwright "$@"
else
    compdef _patchwright patchwright
fi
)",
                       commands, cases);
}

std::string fish(const CLI::App& app) {
    std::string text = "complete -c patchwright -n __fish_use_subcommand -f\n";
    for (const CLI::App* command : app.get_subcommands({})) {
        text += fmt::format("complete -c patchwright -n __fish_use_subcommand -a {} -d '{}'\n",
                            command->get_name(), escaped(command->get_description(), "'\\"));
        for (const CLI::Option* option : named_options(*command)) {
            text += fmt::format("complete -c patchwright -n '__fish_seen_subcommand_from {}'",
                                command->get_name());
            for (const std::string& name : option->get_snames()) text += " -s " + name;
            for (const std::string& name : option->get_lnames()) text += " -l " + name;
            const auto all = choices(*option);
            if (!all.empty())
                text += fmt::format(" -xa '{}'", fmt::join(all, " "));
            else if (takes_value(*option))
                text += takes_file(*option) ? " -r" : " -x";
            text += fmt::format(" -d '{}'\n", escaped(option->get_description(), "'\\"));
        }
    }
    return text;
}

/// Text of a manual page: no line is taken for a request, hyphens can be copied.
std::string troff(const std::string& text) {
    std::string result = escaped(text, "\\-");
    const std::string line_break = "\n.br\n";
    for (std::size_t at = result.find('\n'); at != std::string::npos;
         at = result.find('\n', at + line_break.size()))
        result.replace(at, 1, line_break);
    return result.starts_with(".") || result.starts_with("'") ? "\\&" + result : result;
}

std::string manual_of_options(const CLI::App& command) {
    std::string text;
    for (const CLI::Option* option : command.get_options()) {
        std::string name = option->get_positional()
                               ? option->get_name(true)
                               : fmt::format("{}", fmt::join(all_names(*option), ", "));
        if (takes_value(*option) && !option->get_positional())
            name += " " + option->get_type_name();
        text += fmt::format(".TP\n.B {}\n{}\n", troff(name), troff(option->get_description()));
        if (!option->get_default_str().empty())
            text += fmt::format(".br\nDefault: {}\n", troff(option->get_default_str()));
    }
    return text;
}

std::string manual_of(const CLI::App& command) {
    std::string text =
        fmt::format(".SS {}\n{}\n", command.get_name(), troff(command.get_description())) +
        manual_of_options(command);
    if (!command.get_footer().empty())
        text += fmt::format(".PP\n.nf\n{}\n.fi\n", escaped(command.get_footer(), "\\-"));
    return text;
}

}  // namespace

std::string completion(const CLI::App& app, const std::string& shell) {
    if (shell == "bash") return bash(app);
    return shell == "zsh" ? zsh(app) : fish(app);
}

std::string manual(const CLI::App& app) {
    std::string text = fmt::format(
        ".TH PATCHWRIGHT 1 \"\" \"patchwright {}\"\n.SH NAME\npatchwright \\- {}\n.SH SYNOPSIS\n"
        ".B patchwright\n.I COMMAND\n[options]\n.SH COMMANDS\n",
        base::version(), troff(app.get_description()));
    for (const CLI::App* command : app.get_subcommands({})) text += manual_of(*command);
    std::string footer = app.get_footer();
    std::replace(footer.begin(), footer.end(), '\n', ' ');
    return text + ".SH OPTIONS\nOf every command, before or after its name.\n" +
           manual_of_options(app) + fmt::format(".SH EXIT STATUS\n{}\n", troff(footer));
}

}  // namespace patchwright::cli
