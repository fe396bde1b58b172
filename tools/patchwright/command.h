// What all subcommands share: exit codes, common options, progress and reporting.
#pragma once

#include "files.h"

#include <patchwright/base/about_input.h>
#include <patchwright/base/budget.h>
#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>
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
    const CLI::App* command = nullptr;  ///< whose options these are
};

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html);

/// One run of a subcommand: its report, its clock and its talk to the user.
class Run {
  public:
    /// Checks `files`, and the report's, before anything is read; see check_files().
    Run(const CommonOptions& options, RunFiles files);
    /// Of a run that an error ends: keeps its report for write_failure().
    ~Run();
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    /// Draws the stage on standard error when asked to or on a terminal; stops on signals.
    [[nodiscard]] base::Progress progress() const;
    /// Whether finish() writes the report as HTML.
    [[nodiscard]] bool writes_page() const { return !options_.html.empty(); }
    /// The same with a limit that counts from now.
    [[nodiscard]] base::Budget budget(std::optional<double> limit_s) const;

    /// Ends the stage that ran since the last call, or since the start, under this name; a stage
    /// that runs again adds up.
    void end_stage(const std::string& name);
    /// Adds a stage that something else has timed, and begins the next one now.
    void add_stage(const std::string& name, double seconds);

    /// Remembered in the report, printed to standard error unless quiet.
    void notice(const std::string& text);

    /// Writes the report as JSON and HTML where asked, prints the summary to standard output unless
    /// quiet, and puts all outputs in place.
    /// @return Done, or VerdictMissed where the report's verdict is not met
    int finish();
    /// The same with texts of other kinds than the report's.
    int finish(const std::string& json, const std::string& html, const std::string& text);

    report::RunReport report;
    base::OutputSet outputs;

  private:
    [[nodiscard]] bool shows_progress() const;
    void note_stage(const std::string& name, double seconds);

    const CommonOptions& options_;
    base::StageClock clock_;
};

/// Writes the report of the run that an error has ended as JSON where that was asked for, with the
/// error. What cannot be written is left: the error has been told.
void write_failure(const report::Failure& failure) noexcept;

using base::about_input;

/// Reads a cage whose numbers are in `unit`, in millimetres; fills report.cage.
/// @throw InputError as mesh::read_obj, or when the cage is too small for double precision
mesh::Cage read_cage(Run& run, const std::string& file, base::LengthUnit unit);

/// Adds a cage in `unit` to the run's outputs, and reads it back.
void write_cage(Run& run, const mesh::Cage& cage, const std::string& file, base::LengthUnit unit);

/// Each registers its subcommand; `exit_code` receives what the run ends with.
void register_cage(CLI::App& app, int& exit_code);
void register_compare(CLI::App& app, int& exit_code);
void register_convert(CLI::App& app, int& exit_code);
void register_eval(CLI::App& app, int& exit_code);
void register_export(CLI::App& app, int& exit_code);
void register_family(CLI::App& app, int& exit_code);
void register_fit(CLI::App& app, int& exit_code);
void register_grid(CLI::App& app, int& exit_code);
void register_inspect(CLI::App& app, int& exit_code);
void register_member(CLI::App& app, int& exit_code);
void register_morph(CLI::App& app, int& exit_code);
void register_refit(CLI::App& app, int& exit_code);
void register_subdivide(CLI::App& app, int& exit_code);

}  // namespace patchwright::cli
