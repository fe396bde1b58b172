// The command line: reads arguments, turns errors into the contract's exit codes.
#include "checks.h"
#include "command.h"
#include "help.h"
#include "options.h"
#include "signals.h"

#include <patchwright/base/error.h>
#include <patchwright/base/version.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <new>
#include <sstream>
#include <string_view>
#include <system_error>

namespace patchwright::cli {

namespace {

int fail(int code, const std::string& text) {
    say_last_line(text);
    return code;
}

/// The same, told in the run's report as well.
int fail_with_report(int code, const std::string& text) {
    write_failure({code, text});
    return fail(code, text);
}

/// What an error says, and the exit code that goes with its kind.
int report_error() {
    if (const int signal = stop_signal()) return fail(exit_code_of(signal), message_of(signal));
    try {
        throw;
    } catch (const CLI::ParseError& error) {
        return fail(Usage, std::string(error.what()) + "; see --help");
    } catch (const base::UsageError& error) {
        return fail_with_report(Usage, error.what());
    } catch (const base::InputError& error) {
        return fail_with_report(BadInput, error.what());
    } catch (const base::OutputError& error) {
        return fail_with_report(NotWritten, error.what());
    } catch (const base::TimeLimitReached&) {
        return fail_with_report(
            VerdictMissed,
            "MISSED: the time limit was reached before there was a first result, and "
            "no result was written; try a longer --time-limit or a coarser --tolerance");
    } catch (const std::bad_alloc&) {
        return fail(InternalError, out_of_memory);
    } catch (const std::system_error& error) {
        return fail(InternalError, fmt::format("the system refuses: {}; no file was written or "
                                               "changed",
                                               error.what()));
    } catch (const std::exception& error) {
        // So TBB says that there is no memory for a thread's stack.
        if (std::string_view(error.what()).starts_with("pthread_create"))
            return fail(InternalError, out_of_memory);
        return fail_with_report(InternalError,
                                fmt::format("internal error, please report: {}", error.what()));
    }
}

void register_all(CLI::App& app, int& exit_code) {
    register_convert(app, exit_code);
    register_cage(app, exit_code);
    register_fit(app, exit_code);
    register_refit(app, exit_code);
    register_family(app, exit_code);
    register_member(app, exit_code);
    register_morph(app, exit_code);
    register_export(app, exit_code);
    register_compare(app, exit_code);
    register_inspect(app, exit_code);
    register_grid(app, exit_code);
    register_eval(app, exit_code);
    register_subdivide(app, exit_code);
    for (CLI::App* command : app.get_subcommands({}))
        for (CLI::Option* option : command->get_options())
            if (option->get_items_expected_max() > 0) option->check(is_not_empty());
    describe_commands(app);
    register_help(app);
    // What a subcommand does not know, as --version and --config, is the program's.
    for (CLI::App* command : app.get_subcommands({})) command->fallthrough();
}

int run(int argc, char** argv) {
    CLI::App app{
        "Legacy CAD to a few clean, smooth, untrimmed patches that form one watertight solid.",
        "patchwright"};
    app.set_version_flag("--version", "patchwright " + std::string(base::version()));
    app.set_config("--config", "",
                   "TOML file with options by subcommand, as in [convert] tolerance = \"0.1mm\"; "
                   "those of the command line go first")
        ->type_name("FILE.toml");
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 done and the verdict is met, 1 usage, 2 input unreadable or unusable, 3 the "
        "verdict is\n"
        "not met (tolerance, validity, folds, lost curves or bodies, time limit), 4 output could "
        "not be\nwritten, 5 internal error or out of memory, 128 + number of the signal that "
        "stopped it (Ctrl-C: 130).");
    int exit_code = Done;
    register_all(app, exit_code);
    try {
        check_names(app, std::vector<std::string>(argv + 1, argv + argc));
        app.parse(argc, argv);
        return exit_code;
    } catch (const CLI::ConfigError& error) {
        refuse_config(app, error.what());
    } catch (const CLI::Success& help) {
        std::ostringstream text;
        app.exit(help, text, text);
        write_standard_output(text.str());
        return Done;
    }
}

/// Standard streams that are closed become ones that cannot be used, lest a file that is opened
/// takes their place.
void occupy_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        const int unusable = stream == STDIN_FILENO ? O_WRONLY : O_RDONLY;
        if (::fcntl(stream, F_GETFD) < 0) (void)::open("/dev/null", unusable);
    }
}

}  // namespace

}  // namespace patchwright::cli

int main(int argc, char** argv) {
    using namespace patchwright::cli;
    occupy_standard_streams();
    try {
        reader_process();
        catch_signals();
        return run(argc, argv);
    } catch (...) {
        // Without tidying up, in which HDF5 crashes after a write that failed.
        std::_Exit(report_error());
    }
}
