// What all subcommands share: exit codes, common options, progress and reporting.
#pragma once

#include <patchwright/base/budget.h>
#include <patchwright/base/error.h>
#include <patchwright/base/stage_clock.h>
#include <patchwright/base/units.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/report/run_report.h>

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace patchwright::cli {

/// The exit codes of the contract.
enum ExitCode {
    Done = 0,
    Usage = 1,
    BadInput = 2,
    VerdictMissed = 3,
    NotWritten = 4,
    InternalError = 5
};

/// Options of every subcommand.
struct CommonOptions {
    bool quiet = false;
    bool verbose = false;
    bool progress = false;
    int threads = 0;
    std::string json;  ///< path, or "-" for standard output
    std::string html;
};

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html);

/// One run of a subcommand: its report, its clock and its talk to the user.
class Run {
  public:
    explicit Run(const CommonOptions& options);

    /// Draws the stage on standard error when asked to or on a terminal; stops on Ctrl-C.
    [[nodiscard]] base::Progress progress() const;
    /// The same with a limit that counts from now.
    [[nodiscard]] base::Budget budget(std::optional<double> limit_s) const;

    /// Ends the stage that ran since the last call, or since the start, under this name; a stage
    /// that runs again adds up.
    void end_stage(const std::string& name);
    /// Adds a stage that something else has timed, and begins the next one now.
    void add_stage(const std::string& name, double seconds);

    /// Remembered in the report, printed to standard error unless quiet.
    void notice(const std::string& text);

    /// Writes JSON and HTML where asked, prints the summary to standard output unless quiet.
    /// @return Done, or VerdictMissed where the report's verdict is not met
    int finish();

    report::RunReport report;

  private:
    void note_stage(const std::string& name, double seconds);

    const CommonOptions& options_;
    base::StageClock clock_;
};

/// Reads a cage whose numbers are in `unit`, in millimetres; fills report.cage.
/// @throw InputError as mesh::read_obj, or when the cage is too small for double precision
mesh::Cage read_cage(Run& run, const std::string& file, base::LengthUnit unit);

/// Calls `body`; errors of what `file` holds name it.
template <class Body>
auto naming(const std::string& file, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const base::InputError& error) {
        throw base::InputError(file + ": " + error.what());
    }
}

/// Writes a cage, atomically, in `unit`.
void write_cage(const mesh::Cage& cage, const std::string& file, base::LengthUnit unit);

/// Each registers its subcommand; `exit_code` receives what the run ends with.
void register_cage(CLI::App& app, int& exit_code);
void register_compare(CLI::App& app, int& exit_code);
void register_convert(CLI::App& app, int& exit_code);
void register_eval(CLI::App& app, int& exit_code);
void register_export(CLI::App& app, int& exit_code);
void register_fit(CLI::App& app, int& exit_code);
void register_grid(CLI::App& app, int& exit_code);
void register_inspect(CLI::App& app, int& exit_code);
void register_subdivide(CLI::App& app, int& exit_code);

}  // namespace patchwright::cli
