#include "command.h"

#include "checks.h"
#include "signals.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/mesh/obj.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <utility>

namespace patchwright::cli {

namespace {

/// More than machines have; each takes a stack.
constexpr int most_threads = 1024;

constexpr const char* erased_line = "\r\033[K";

/// Stage, share done, seconds since the start, and what the stage will take at its pace so far.
class ProgressLine {
  public:
    void draw(std::string_view stage, double fraction) {
        if (stage != stage_ || fraction < fraction_) {
            stage_ = stage;
            stage_start_ = Clock::now();
        }
        fraction_ = fraction;
        const double spent = seconds_since(stage_start_);
        constexpr double least_share = 0.05, least_seconds = 1.0;  // to be told a pace
        const std::string left =
            fraction > least_share && spent > least_seconds
                ? fmt::format(", {:.0f} s left", spent * (1.0 - fraction) / fraction)
                : std::string();
        const std::string line = fmt::format("{:<24} {:3.0f} % {:6.1f} s{}", stage, 100 * fraction,
                                             seconds_since(start_), left);
        if (line != last_) write_standard_error(erased_line + line);
        last_ = line;
    }

  private:
    using Clock = std::chrono::steady_clock;
    static double seconds_since(Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    }

    Clock::time_point start_ = Clock::now(), stage_start_ = start_;
    std::string stage_, last_;
    double fraction_ = 0.0;
};

/// The report of the run that an error has ended.
struct FailedRun {
    std::string json;  ///< where it goes; empty: nowhere
    report::RunReport report;
};

FailedRun& failed_run() {
    static FailedRun run;
    return run;
}

/// The command and its options, but for those that are not given and have no default.
std::vector<std::pair<std::string, std::string>> used_options(const CLI::App& command) {
    std::vector<std::pair<std::string, std::string>> used{{"command", command.get_name()}};
    for (const CLI::Option* option : command.get_options()) {
        const std::string name = option->get_single_name();
        if (name == "help" || name == "version") continue;
        if (option->get_items_expected_max() == 0)
            used.emplace_back(name, option->count() > 0 ? "true" : "false");
        else if (option->count() > 0)
            used.emplace_back(name, fmt::format("{}", fmt::join(option->results(), " ")));
        else if (!option->get_default_str().empty())
            used.emplace_back(name, option->get_default_str());
    }
    return used;
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html) {
    options.command = &command;
    command.add_flag("-q,--quiet", options.quiet, "print errors only");
    command.add_flag("-v,--verbose", options.verbose,
                     "print all figures, and stage times as they end");
    command.add_flag("--progress", options.progress,
                     "show progress even where there is no terminal");
    command.add_option("--threads", options.threads, "threads to use; 0: all cores")
        ->check(number_in(0, most_threads));
    command.add_option("--json", options.json, "write the report as JSON ('-': standard output)");
    if (with_html)
        command.add_option("--report", options.html,
                           "write the report as HTML ('-': standard output)");
}

Run::Run(const CommonOptions& options, RunFiles files) : options_(options) {
    files.outputs.push_back({"--json", options.json, OutputKind::Json});
    files.outputs.push_back({"--report", options.html, OutputKind::Html});
    check_files(files);
    base::set_thread_count(options.threads);
    report.options = used_options(*options.command);
}

Run::~Run() {
    if (std::uncaught_exceptions() == 0) return;
    if (shows_progress()) write_standard_error(erased_line);
    failed_run() = {options_.json, std::move(report)};
}

void write_failure(const report::Failure& failure) noexcept {
    FailedRun& failed = failed_run();
    if (failed.json.empty()) return;
    try {
        failed.report.error = failure;
        const std::string json = report::to_json(failed.report);
        if (is_standard_output(failed.json)) {
            write_standard_output(json);
            return;
        }
        base::OutputSet output;
        output.add(failed.json, json);
        output.commit();
    } catch (const std::exception&) {
    }
}

bool Run::shows_progress() const {
    return !options_.quiet && (options_.progress || ::isatty(STDERR_FILENO) != 0);
}

base::Progress Run::progress() const {
    return [show = shows_progress(), line = ProgressLine()](std::string_view stage,
                                                            double fraction) mutable {
        if (show) line.draw(stage, fraction);
        return stop_signal() == 0;
    };
}

base::Budget Run::budget(std::optional<double> limit_s) const {
    if (!limit_s) return base::Budget(std::nullopt, progress());
    return base::Budget(base::Budget::Seconds(*limit_s), progress());
}

void Run::end_stage(const std::string& name) {
    note_stage(name, clock_.end(name));
    stop_if_asked();
}

void Run::add_stage(const std::string& name, double seconds) {
    clock_.add(name, seconds);
    note_stage(name, seconds);
}

void Run::note_stage(const std::string& name, double seconds) {
    report.seconds = clock_.seconds();
    if (options_.verbose)
        write_standard_error(
            fmt::format("{}{}: {:.2f} s\n", shows_progress() ? erased_line : "", name, seconds));
}

void Run::notice(const std::string& text) {
    report.notices.push_back(text);
    if (!options_.quiet)
        write_standard_error(
            fmt::format("{}note: {}\n", shows_progress() ? erased_line : "", text));
}

int Run::finish() {
    if (shows_progress()) write_standard_error(erased_line);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    report.peak_memory_mb = double(usage.ru_maxrss) / 1024.0;
    return finish(options_.json.empty() ? "" : report::to_json(report),
                  options_.html.empty() ? "" : report::to_html(report),
                  report::to_text(report, options_.verbose ? report::TextDetail::Full
                                                           : report::TextDetail::Brief));
}

int Run::finish(const std::string& json, const std::string& html, const std::string& text) {
    const std::string* printed = options_.quiet ? nullptr : &text;
    for (const auto& [file, content] :
         {std::pair(&options_.json, &json), {&options_.html, &html}}) {
        if (file->empty()) continue;
        if (is_standard_output(*file))
            printed = content;
        else
            outputs.add(*file, *content);
    }
    stop_if_asked();
    if (printed != nullptr) write_standard_output(*printed);
    stop_if_asked();
    outputs.commit();
    const int code = report.verdict && !report.verdict->met() ? VerdictMissed : Done;
    outputs_are_in_place(code);
    return code;
}

mesh::Cage read_cage(Run& run, const std::string& file, base::LengthUnit unit) {
    mesh::BuildResult result = mesh::read_obj(std::filesystem::path(file));
    result.cage.points *= base::millimetres_per(unit);
    const double diagonal = geom::bounding_box(result.cage.points).diagonal();
    if (!(diagonal >= 1.0 / geom::largest_coordinate))
        throw base::InputError(
            fmt::format("{}: all vertices are in one place, within {:.3g} mm", file, diagonal));
    if (result.removed_vertices > 0) {
        run.notice(fmt::format("{}: {} inner vertices with two faces only were removed", file,
                               result.removed_vertices));
    }
    run.report.cage = mesh::summarise(*result.cage.topology);
    if (result.flipped_faces > 0) {
        run.notice(fmt::format("{}: {} faces were turned to agree with the others", file,
                               result.flipped_faces));
    }
    return std::move(result.cage);
}

void write_cage(Run& run, const mesh::Cage& cage, const std::string& file, base::LengthUnit unit) {
    mesh::Cage scaled = cage;
    scaled.points /= base::millimetres_per(unit);
    const auto pending = std::make_shared<base::PendingFile>(file);
    pending->write(mesh::obj_text(scaled));
    try {
        const mesh::Cage read = mesh::read_obj(pending->path()).cage;
        if (read.points != scaled.points) throw base::InputError("other points");
    } catch (const base::InputError& error) {
        throw base::OutputError(fmt::format(
            "{}: what was written cannot be read back, and is not kept: {}", file, error.what()));
    }
    run.outputs.add(pending);
}

}  // namespace patchwright::cli
