// The command line: reads arguments, turns errors into the contract's exit codes.
#include "command.h"

#include <patchwright/base/error.h>
#include <patchwright/base/version.h>
#include <patchwright/occ/guarded_read.h>

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

namespace patchwright::cli {

extern volatile std::sig_atomic_t interrupted;

namespace {

void on_interrupt(int) { interrupted = 1; }

int fail(int code, const std::string& text) {
    fmt::print(stderr, "patchwright: {}\n", text);
    return code;
}

int run(int argc, char** argv) {
    CLI::App app{
        "Legacy CAD to a few clean, smooth, untrimmed patches that form one watertight solid."};
    app.set_version_flag("--version", "patchwright " + std::string(base::version()));
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 done and the verdict is met, 1 usage, 2 input unreadable or unusable, 3 the "
        "verdict is\n"
        "not met (tolerance, validity, folds, lost curves or bodies, time limit), 4 output could "
        "not be\nwritten, 5 internal error, 130 interrupted.");
    int exit_code = Done;
    register_convert(app, exit_code);
    register_cage(app, exit_code);
    register_fit(app, exit_code);
    register_export(app, exit_code);
    register_compare(app, exit_code);
    register_inspect(app, exit_code);
    register_grid(app, exit_code);
    register_eval(app, exit_code);
    register_subdivide(app, exit_code);
    try {
        app.parse(argc, argv);
        return exit_code;
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        return fail(Usage, std::string(error.what()) + "; see --help");
    } catch (const base::InvalidArgument& error) {
        return fail(Usage, error.what());
    } catch (const base::InputError& error) {
        return fail(BadInput, error.what());
    } catch (const base::OutputError& error) {
        return fail(NotWritten, error.what());
    } catch (const base::TimeLimitReached&) {
        return fail(VerdictMissed,
                    "MISSED: the time limit was reached before there was a first result, and "
                    "nothing was written; try a longer --time-limit or a coarser --tolerance");
    } catch (const base::Cancelled&) {
        return fail(130, "interrupted; nothing was written");
    } catch (const std::bad_alloc&) {
        return fail(InternalError, "out of memory; use a smaller cage or fewer --max-levels");
    } catch (const std::exception& error) {
        return fail(InternalError, fmt::format("internal error, please report: {}", error.what()));
    }
}

}  // namespace

}  // namespace patchwright::cli

int main(int argc, char** argv) {
    patchwright::occ::serve_read(argc, argv);
    std::signal(SIGINT, patchwright::cli::on_interrupt);
    return patchwright::cli::run(argc, argv);
}
