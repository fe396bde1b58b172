#include "fitting.h"
#include "output.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/inspect_closely.h>

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace patchwright::cli {

namespace {

struct ConvertOptions {
    CommonOptions common;
    OutputOptions output;
    FitCommandOptions fit;
    LayoutOptions layout;
    InputOptions read;
    std::string input, cage, cage_out;
    int samples = 20000;
};

// Cages made one after the other at most, one more where the best one just misses, and faces of one
// that is tried after the first.
constexpr int most_tries = 3, most_faces_again = 4000;
constexpr double just_missed_by = 1.5;

struct Attempt {
    mesh::Cage fitted;
    report::RunReport report;
    std::shared_ptr<const occ::CadReference> output;  ///< of what was written
    double deviation = 0.0;  ///< the larger one of both ways, of the diagonal, by fit and check
    double tolerance = 0.0;  ///< of the diagonal
    bool valid = false;      ///< what the file holds, as read back
    bool written = false;    ///< else figures are those of the model in memory

    [[nodiscard]] bool met() const { return deviation <= tolerance && valid; }
    /// Long sharp curves of the input that are none of the output's.
    [[nodiscard]] std::size_t lost_curves() const {
        const auto& curves = report.deviation->long_sharp;
        return curves ? curves->missed.size() : 0;
    }
    [[nodiscard]] bool better_than(const Attempt& other) const {
        if (valid != other.valid) return valid;
        if (met() && other.met() && lost_curves() != other.lost_curves())
            return lost_curves() < other.lost_curves();
        return deviation < other.deviation;
    }
};

/// How far caps may lie from the limit surface, millimetres.
double caps(const Run& run) { return caps_share * run.report.fit->tolerance; }

/// Measures what an attempt has made.
void measure(Run& run, const ConvertOptions& options, Attempt& attempt, const occ::CadModel& model,
             const geom::ModelSurface& reference) {
    attempt.output = std::make_shared<const occ::CadReference>(model);
    // Bounds take long where the result is far off, and count for the one that is kept only.
    compare_models(run, *attempt.output, reference, options.samples, run.report.fit->tolerance,
                   false);
    run.end_stage("check");
    const report::DeviationFigures& deviation = *run.report.deviation;
    // The fit looks at more points than the check: what it has found counts too.
    const fit::FitLevel& fitted = run.report.fit->levels[std::size_t(run.report.fit->best_level)];
    attempt.deviation = std::max({deviation.output_to_input.max, deviation.input_to_output.max,
                                  fitted.max_mm, fitted.reverse_max_mm}) /
                        reference.bounds().diagonal();
    attempt.valid = run.report.solid->valid;
    run.report.fit->met = attempt.met();
    attempt.report = run.report;
}

/// Writes an attempt's model and measures the file.
void settle(Run& run, const ConvertOptions& options, Attempt& attempt, const Assembled& assembled,
            const geom::ModelSurface& reference) {
    const occ::CadModel written = write_assembled(run, assembled, options.output, run.report.unit);
    attempt.written = true;
    measure(run, options, attempt, written, reference);
}

Assembled assembled(Run& run, const ConvertOptions& options, const Attempt& attempt,
                    const geom::ModelSurface& reference) {
    return assemble_patches(run, attempt.fitted, options.output, caps(run), &reference);
}

/// Fits and measures: the file, or where the fit itself has missed, the model in memory; writing
/// and reading take longer than measuring.
Attempt attempt(Run& run, const ConvertOptions& options, const mesh::Cage& cage,
                const FitCommandOptions& fit, const geom::ModelSurface& reference,
                PartFits* parts = nullptr) {
    Attempt result;
    result.tolerance = relative_tolerance(fit, reference);
    result.fitted = fit_cage(run, cage, reference, fit, parts);
    const bool fit_met = run.report.fit->met;
    const Assembled made = assembled(run, options, result, reference);
    if (!fit_met) {
        inspect_output(run, made, options.output.file);
        measure(run, options, result, made.model, reference);
        if (!result.met()) return result;
    }
    settle(run, options, result, made, reference);
    return result;
}

/// Makes an earlier attempt's figures the report's.
void take(Run& run, const Attempt& attempt) {
    const auto seconds = run.report.seconds;
    const auto notices = run.report.notices;
    run.report = attempt.report;
    run.report.seconds = seconds;
    run.report.notices = notices;
}

int finish(Run& run, const ConvertOptions& options, const Attempt& attempt,
           const geom::ModelSurface& reference) {
    bound_deviation(run, *attempt.output, reference);
    run.end_stage("check");
    if (!options.cage_out.empty())
        write_cage(attempt.fitted, options.cage_out,
                   base::parse_length_unit(options.fit.cage_unit));
    if (!attempt.valid)
        run.notice(
            fmt::format("{}: the kernel's check finds the shape invalid; finer cages or "
                        "--cage may help",
                        options.output.file));
    run.finish();
    return attempt.met() ? Done : ToleranceMissed;
}

/// How the next cage is made: finer where the last one missed. Far off, the recognised shape is not
/// what the model is; blocks along faces, which start coarse, get finer once as long as they are
/// few and lose no curves.
LayoutOptions next_layout(const LayoutOptions& last, const Attempt& attempt,
                          const cage::CageResult& made, double diagonal) {
    constexpr double far_off = 10.0, radius_rel = 0.04;
    constexpr int few_faces = 500;
    LayoutOptions next = last;
    if (made.method == cage::Method::Aligned) {
        const bool again = made.from_faces ? last.fineness == 1.0 && attempt.lost_curves() == 0 &&
                                                 made.cage.topology->face_count() < few_faces
                                           : attempt.deviation <= far_off * attempt.tolerance;
        if (!again && last.method == "auto")
            next = {.method = "remesh", .target_faces = last.target_faces};
        else
            next.fineness *= 2.0;
        return next;
    }
    const report::DeviationFigures& deviation = *attempt.report.deviation;
    const int round = last.finer_at.empty() ? 0 : last.finer_at.back().round + 1;
    for (const measure::Deviation* way : {&deviation.output_to_input, &deviation.input_to_output}) {
        for (const measure::DeviationPlace& place : way->worst) {
            const auto near = [&](const auto& other) {
                return (other.point - place.point).norm() < 0.5 * radius_rel * diagonal;
            };
            const auto fresh = next.finer_at.begin() + std::ptrdiff_t(last.finer_at.size());
            if (place.distance > 0.8 * attempt.tolerance * diagonal &&
                std::none_of(fresh, next.finer_at.end(), near))
                next.finer_at.push_back({place.point, radius_rel * diagonal, round});
        }
    }
    // Nothing was recognised, and blocks were refused: they would be again.
    if (made.recognised == 0 && !made.from_faces && next.finer_at.size() > last.finer_at.size())
        next.method = "remesh";
    return next;
}

/// What the next cage will be like, for the user; empty when it would be the same again.
std::string describe_next(const LayoutOptions& last, const LayoutOptions& next) {
    const std::size_t places = next.finer_at.size() - last.finer_at.size();
    if (next.method != last.method && places == 0) return "remeshed next";
    if (next.fineness != last.fineness) return "next with twice as many lines";
    if (places == 0) return {};
    return fmt::format("next with edges of half the length around {} places", places);
}

/// Makes cages until one meets the tolerance; the best one's output is what is left on disk.
Attempt best_of_tries(Run& run, const ConvertOptions& options, const Input& input) {
    const geom::ModelSurface& reference = input.reference();
    const double tolerance = relative_tolerance(options.fit, reference);
    LayoutOptions how = options.layout;
    std::optional<PartFits> parts = part_fits(run, input);
    std::optional<Attempt> best;
    bool best_is_written = true;
    int best_number = 0;
    for (int number = 1;; ++number) {
        const cage::CageResult made = make_cage(run, input, how, tolerance);
        run.end_stage("layout");
        const int faces = made.cage.topology->face_count();
        if (best && faces > most_faces_again) {
            run.notice(fmt::format("another cage would have {} faces: not tried", faces));
            break;
        }
        // The form of a recognised shape's cage is worth holding on to, but not at any price.
        std::optional<Attempt> of_this;
        bool met = false;
        for (const bool held : {true, false}) {
            FitCommandOptions fit = for_made_cage(options.fit, made);
            if (held && !fit.preserve_parametrisation) continue;
            fit.preserve_parametrisation = held;
            Attempt now =
                attempt(run, options, made.cage, fit, reference, parts ? &*parts : nullptr);
            // Blocks that lose sharp curves are no better than triangles that keep them.
            met = now.met() && (now.lost_curves() == 0 || !made.from_faces || how.method != "auto");
            if (held && !met)
                run.notice(fmt::format(
                    "cage {} of {} faces, held to its form, leaves {:.2g} of the diagonal", number,
                    faces, now.deviation));
            const bool better = !best || now.better_than(*best);
            if (now.written) best_is_written = better;
            if (better) {
                best = now;
                best_number = number;
            }
            if (!of_this || now.better_than(*of_this)) of_this = std::move(now);
            if (met) break;
        }
        const LayoutOptions next = next_layout(how, *of_this, made, reference.bounds().diagonal());
        const bool nearly = best->valid && best->deviation < just_missed_by * best->tolerance;
        const bool last = met || number >= most_tries + (nearly ? 1 : 0);
        const std::string another = last ? std::string() : describe_next(how, next);
        if (!met || number > 1) {
            run.notice(fmt::format(
                "cage {} of {} faces leaves {:.2g} of the diagonal{}{}{}{}", number, faces,
                of_this->deviation, of_this->valid ? "" : ", and the shape is not valid",
                of_this->lost_curves() == 0 ? "" : ", long sharp curves are lost",
                another.empty() ? "" : "; ", another));
        }
        how = next;
        if (another.empty()) break;
    }
    if (!best->met())
        run.notice(
            fmt::format("no cage meets the tolerance; kept is the result of cage {}", best_number));
    take(run, *best);
    if (!best->written)
        settle(run, options, *best, assembled(run, options, *best, reference), reference);
    else if (!best_is_written)
        write_patches(run, best->fitted, options.output, run.report.unit, caps(run), &reference);
    return std::move(*best);
}

int convert(const ConvertOptions& options) {
    occ::file_format(options.output.file);
    const auto cage_unit = base::parse_length_unit(options.fit.cage_unit);
    base::parse_length(options.fit.tolerance);

    Run run(options.common);
    mesh::Cage cage;
    if (!options.cage.empty()) cage = read_cage(run, options.cage, cage_unit);
    Input input = read_input(run, options.input, options.read);
    if (input.model) {
        for (const auto& [a, b] : occ::overlapping_solids(*input.model)) {
            run.notice(fmt::format("solids {} and {} of {} overlap; they stay separate bodies", a,
                                   b, options.input));
        }
    }
    if (options.output.unit != "input")
        run.report.unit = base::parse_length_unit(options.output.unit);
    prepare(run, input);
    const geom::ModelSurface& reference = input.reference();
    note_chord_error(run, input,
                     relative_tolerance(options.fit, reference) * reference.bounds().diagonal());
    if (!options.cage.empty()) {
        run.end_stage("layout");
        Attempt only = attempt(run, options, cage, options.fit, reference);
        if (!only.written)
            settle(run, options, only, assembled(run, options, only, reference), reference);
        return finish(run, options, only, reference);
    }
    return finish(run, options, best_of_tries(run, options, input), reference);
}

}  // namespace

void register_convert(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<ConvertOptions>();
    CLI::App* command = app.add_subcommand(
        "convert", "CAD file, with or without a cage, to one clean solid, measured");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("--cage", options->cage,
                        "control mesh (OBJ); left away: made from the CAD");
    command->add_option("--cage-out", options->cage_out, "write the fitted control mesh (OBJ)");
    add_input_options(*command, options->read);
    command->add_option("--samples", options->samples, "samples for the deviation, each way")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    add_output_options(*command, options->output);
    add_layout_options(*command, options->layout);
    add_fit_options(*command, options->fit);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = convert(*options); });
}

}  // namespace patchwright::cli
