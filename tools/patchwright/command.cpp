#include "command.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/base/pending_file.h>
#include <patchwright/mesh/obj.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>

namespace patchwright::cli {

volatile std::sig_atomic_t interrupted = 0;

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html) {
    command.add_flag("-q,--quiet", options.quiet, "print errors only");
    command.add_flag("-v,--verbose", options.verbose, "print stage times as they end");
    command.add_flag("--progress", options.progress,
                     "show progress even where there is no terminal");
    command.add_option("--threads", options.threads, "threads to use; 0: all cores")
        ->check(CLI::NonNegativeNumber);
    command.add_option("--json", options.json, "write the report as JSON ('-': standard output)");
    if (with_html) command.add_option("--report", options.html, "write the report as HTML");
}

Run::Run(const CommonOptions& options) : options_(options) {
    base::set_thread_count(options.threads);
}

base::Progress Run::progress() const {
    const bool show = !options_.quiet && (options_.progress || ::isatty(STDERR_FILENO) != 0);
    return [show, last = std::string(), start = std::chrono::steady_clock::now()](
               std::string_view stage, double fraction) mutable {
        if (show) {
            const double seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            const auto line =
                fmt::format("{:<10} {:3.0f} % {:6.1f} s", stage, 100 * fraction, seconds);
            if (line != last) fmt::print(stderr, "\r{}\033[K", line);
            std::fflush(stderr);
            last = line;
        }
        return interrupted == 0;
    };
}

base::Budget Run::budget(std::optional<double> limit_s) const {
    if (!limit_s) return base::Budget(std::nullopt, progress());
    return base::Budget(base::Budget::Seconds(*limit_s), progress());
}

void Run::end_stage(const std::string& name) {
    note_stage(name, clock_.end(name));
    if (interrupted != 0) throw base::Cancelled();
}

void Run::add_stage(const std::string& name, double seconds) {
    clock_.add(name, seconds);
    note_stage(name, seconds);
}

void Run::note_stage(const std::string& name, double seconds) {
    report.seconds = clock_.seconds();
    if (options_.verbose) fmt::print(stderr, "{}: {:.2f} s\n", name, seconds);
}

void Run::notice(const std::string& text) {
    report.notices.push_back(text);
    if (!options_.quiet) fmt::print(stderr, "note: {}\n", text);
}

int Run::finish() {
    if (!options_.quiet && (options_.progress || ::isatty(STDERR_FILENO) != 0)) {
        fmt::print(stderr, "\r\033[K");
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    report.peak_memory_mb = double(usage.ru_maxrss) / 1024.0;
    if (!options_.html.empty()) base::write_text_file(options_.html, report::to_html(report));
    if (options_.json == "-") {
        fmt::print("{}", report::to_json(report));
    } else {
        if (!options_.json.empty()) base::write_text_file(options_.json, report::to_json(report));
        if (!options_.quiet) fmt::print("{}", report::to_text(report));
    }
    return report.verdict && !report.verdict->met() ? VerdictMissed : Done;
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

void write_cage(const mesh::Cage& cage, const std::string& file, base::LengthUnit unit) {
    mesh::Cage scaled = cage;
    scaled.points /= base::millimetres_per(unit);
    base::write_text_file(file, mesh::obj_text(scaled));
}

}  // namespace patchwright::cli
