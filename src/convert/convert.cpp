#include "convert/body_contacts.h"
#include "convert/earlier_state.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>
#include <patchwright/base/stage_clock.h>
#include <patchwright/cage/bodies.h>
#include <patchwright/convert/convert.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/measure/crease_rule.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/occ/inspect_closely.h>

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

namespace patchwright::convert {

namespace {

/// Of the tolerance, for caps at extraordinary vertices and for what lies between the fit's
/// samples; the rest is for the fit.
constexpr double caps_share = 0.05;
/// Levels of a made cage that may gain nothing: another cage may serve better.
constexpr int idle_levels = 2;

/// How far a fit grows: a made cage that is too coarse by more is better made anew.
struct Growth {
    int levels, vertices;
};

/// Cages that were given, or recognised as wings and the like: as far as memory allows.
constexpr Growth unlimited_growth{12, 200000};
/// More vertices than this are not a few clean patches any more.
constexpr int most_vertices = 40000;
/// Blocks are coarse and refined in single strips: some vertices to begin with, and so many a face.
constexpr int first_vertices = 2000, vertices_a_face = 12;
/// Levels of blocks and of remeshed cages, whose faces have the size that the shape asks for: two
/// are 16 times as many. Blocks that meet do so within them (48 random parts, wing and fuselage).
constexpr int made_levels = 2;

Growth growth_of(CageKind kind, int faces) {
    switch (kind) {
        case CageKind::Given:
        case CageKind::Sections: return unlimited_growth;
        case CageKind::Field:
        case CageKind::Blocks:
            return {made_levels, std::min(most_vertices, first_vertices + vertices_a_face * faces)};
        case CageKind::Remeshed: return {made_levels, most_vertices};
    }
    return unlimited_growth;
}

/// For work without which there is a result. @return false when it ran out of memory
template <class Work>
bool memory_suffices(const Work& work) {
    const base::MayRunOutOfMemory scope;
    try {
        work();
        return true;
    } catch (const std::bad_alloc&) {
        return false;
    }
}

/// What a run of attempts shares.
class AttemptRunner {
  public:
    AttemptRunner(const Source& source, const std::filesystem::path& output,
                  const ConvertOptions& options, const base::Budget& budget)
        : source_(source), output_(output), options_(options), budget_(budget) {}

    /// @throw TimeLimitReached when no level of the fit was completed
    Attempt fitted(const AttemptPlan& plan, const std::vector<Attempt>& attempts = {}) {
        Attempt attempt{.plan = plan};
        number_ = attempts.size() + 1;
        make_cage(attempt, attempts);
        clock.end("layout");
        fit(attempt);
        clock.end("fit");
        return attempt;
    }

    /// @throw TimeLimitReached as fitted()
    Attempt carry_out(const AttemptPlan& plan, const std::vector<Attempt>& attempts) {
        Attempt attempt = fitted(plan, attempts);
        make_and_measure(attempt, attempts);
        attempt.verdict =
            assess(attempt, source_, options_.tolerance_mm, options_.normal_tolerance_rad);
        return attempt;
    }

    /// Of the patches of what was fitted only.
    void find_folds(Attempt& attempt, measure::VerdictFigures& figures) {
        attempt.folds = folds_of(make_shape(attempt.fitted, options_.shape, shape_tolerance()));
        const auto& fold = attempt.folds.worst;
        figures.fold_rad = fold ? measure::Worst{fold->angle_rad, fold->point} : measure::Worst{};
        clock.end("check");
    }

    /// Of the patches of what was fitted only.
    void find_normals(const Attempt& attempt, measure::VerdictFigures& figures) {
        const Shape shape = make_shape(attempt.fitted, options_.shape, shape_tolerance());
        add_normals(
            figures,
            measure::measure_relative_fairness(
                occ::CadReference(shape.model), surface(),
                {.samples = options_.samples, .lines = 0, .progress = told(budget_.unlimited())}));
        figures.normal_tolerance_rad = options_.normal_tolerance_rad;
        clock.end("check");
    }

    Conversion result;
    base::StageClock clock;

  private:
    [[nodiscard]] const geom::ModelSurface& surface() const { return source_.surface(); }
    [[nodiscard]] ShapeTolerance shape_tolerance() const {
        return {caps_share * options_.tolerance_mm, options_.tolerance_mm};
    }
    [[nodiscard]] double diagonal() const { return surface().bounds().diagonal(); }
    /// From the second attempt on its number goes before the stage.
    [[nodiscard]] base::Progress told(base::Progress progress) const {
        if (number_ < 2 || !progress) return progress;
        return [progress = std::move(progress), number = number_](std::string_view stage,
                                                                  double fraction) {
            return progress(fmt::format("attempt {}, {}", number, stage), fraction);
        };
    }
    void notice(std::string text) {
        auto& all = result.notices;
        if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
    }

    void make_cage(Attempt& attempt, const std::vector<Attempt>& attempts) {
        const AttemptPlan& plan = attempt.plan;
        if (plan.given) {
            attempt.cage = *options_.cage;
            return;
        }
        if (!attempts.empty() && attempts.back().plan.same_cage(plan)) {
            attempt.kind = attempts.back().kind;
            attempt.cage = attempts.back().cage;
            attempt.layout = attempts.back().layout;
            attempt.faces_refused = attempts.back().faces_refused;
            return;
        }
        cage::CageOptions making = plan.cage;
        making.progress = told(budget_.limited());
        cage::CageResult made = cage::make_cage(surface(), making);
        for (std::string& text : made.notices) notice(std::move(text));
        attempt.kind = made.method == cage::Method::Remesh ? CageKind::Remeshed
                       : made.from_field                   ? CageKind::Field
                       : made.from_faces                   ? CageKind::Blocks
                                                           : CageKind::Sections;
        attempt.cage = std::move(made.cage);
        attempt.layout = std::move(made.layout);
        attempt.faces_refused = made.faces_refused;
    }

    void fit(Attempt& attempt) {
        const Growth growth = growth_of(attempt.kind, attempt.cage.topology->face_count());
        fit::FitOptions fitting{
            .tolerance_mm = (1.0 - caps_share) * attempt.plan.fit_share * options_.tolerance_mm,
            .refinement = attempt.kind == CageKind::Remeshed ? fit::RefinementScope::Global
                                                             : options_.refinement,
            .max_levels = options_.max_levels.value_or(growth.levels),
            .max_vertices = growth.vertices,
            .preserve_parametrisation = attempt.plan.preserve_parametrisation,
            .symmetry = options_.symmetry,
            .crease_rule = options_.crease_rule,
            .interpolate = options_.interpolate,
            .progress = told(budget_.limited())};
        if (attempt.kind != CageKind::Given) fitting.max_idle_levels = idle_levels;
        std::optional<fit::FitResult> of_parts;
        if (attempt.kind != CageKind::Given) of_parts = fit_by_parts(attempt.cage, fitting);
        fit::FitResult fitted = of_parts         ? std::move(*of_parts)
                                : options_.refit ? refitted(attempt, fitting)
                                                 : fit::fit(attempt.cage, surface(), fitting);
        if (fitted.faces_away)
            notice(
                "the cage faces the other way than the model; it was fitted so, and so does the "
                "result (reverse the order of the vertices of its faces to turn it)");
        attempt.stopped_by_time_limit = fitted.stopped_by_time_limit;
        attempt.keeps_cage = options_.refit;
        attempt.fit = {.carried = std::move(attempt.fit.carried),
                       .tolerance = options_.tolerance_mm,
                       .best_level = fitted.best_level,
                       .symmetry_axis = fitted.symmetry_axis,
                       .off_catmull_clark_mm = off_catmull_clark(fitted.cage),
                       .before = measure::measure_fairness(attempt.cage),
                       .after = measure::measure_fairness(fitted.cage),
                       .levels = std::move(fitted.levels)};
        attempt.fitted = std::move(fitted.cage);
    }

    static std::optional<double> off_catmull_clark(const mesh::Cage& cage) {
        if (!cage.topology->has_runouts()) return std::nullopt;
        return measure::distance_from_catmull_clark(cage);
    }

    [[nodiscard]] fit::FitResult refitted(Attempt& attempt, const fit::FitOptions& fitting) const {
        const auto count_folds = [&](const mesh::Cage& cage) {
            return folds_of(make_shape(cage, options_.shape, shape_tolerance())).folded;
        };
        check_earlier_state(attempt.cage, source_);
        std::optional<fit::ModelChange> change;
        if (const Source* earlier = options_.earlier) {
            check_fitted_to(attempt.cage, *earlier, source_);
            change.emplace(fit::ModelState{earlier->surface(), earlier->input.file},
                           fit::ModelState{surface(), source_.input.file});
        }
        fit::RefitResult carried = fit::refit(
            attempt.cage, surface(),
            {.fit = fitting, .change = change ? &*change : nullptr, .count_folds = count_folds});
        attempt.fit.carried = std::move(carried.stages);
        return std::move(carried.fit);
    }

    /// Each part of the cage to its own body; nothing where there is one body only, or parts lie on
    /// none of them alone: of the whole model such a part would be drawn to what others are for.
    std::optional<fit::FitResult> fit_by_parts(const mesh::Cage& cage,
                                               const fit::FitOptions& options) {
        if (source_.bodies < 2 || !source_.model) return std::nullopt;
        const auto parts = mesh::connected_parts(cage);
        const auto references =
            cage::references_of_parts(parts, bodies(budget_.limited()), surface());
        if (std::find(references.begin(), references.end(), &surface()) != references.end())
            return std::nullopt;
        fit::PartsFit fitted = fit::fit_parts(parts, references, options, known_parts_);
        std::move(fitted.parts.begin(), fitted.parts.end(), std::back_inserter(known_parts_));
        return std::move(fitted.whole);
    }

    /// Those of a CAD model; none of triangles.
    const std::vector<geom::BodyReference>& bodies(const base::Progress& progress) {
        if (!bodies_ && source_.model)
            bodies_ =
                occ::body_references(*source_.model, source_.reference_options(told(progress)));
        if (!bodies_) bodies_.emplace();
        return *bodies_;
    }

    /// Whether an attempt may become the best one, as far as its fit tells.
    [[nodiscard]] bool may_win(const Attempt& attempt, const std::vector<Attempt>& attempts) const {
        const auto best = choose_best(attempts);
        if (!best) return true;
        // No verdict is better than one that misses nothing but what the fit has missed.
        const auto& fitted = attempt.fit.levels[std::size_t(attempt.fit.best_level)];
        const measure::Verdict at_best =
            measure::assess({.tolerance_mm = options_.tolerance_mm,
                             .diagonal_mm = source_.input.diagonal,
                             .output_to_input_mm = measure::Worst{fitted.largest(), {}}});
        return measure::better(at_best, attempts[*best].verdict);
    }

    void make_and_measure(Attempt& attempt, const std::vector<Attempt>& attempts) {
        const base::Progress progress = told(budget_.unlimited());
        const double tolerance = options_.tolerance_mm;
        const Shape shape =
            make_shape(attempt.fitted, options_.shape, shape_tolerance(), &surface());
        for (const std::string& text : shape.notices) notice(text);
        clock.end("patch");
        std::optional<occ::CadModel> written;
        if (may_win(attempt, attempts)) {
            attempt.file = std::make_shared<base::PendingFile>(output_);
            occ::WriteOptions writing = options_.shape.write;
            if (!writing.name) writing.name = output_.stem().string();
            written = write_and_read_back(shape, *attempt.file, writing);
            clock.end("write");
        }
        const occ::CadModel& model = written ? *written : shape.model;
        attempt.patches = shape.patches;
        attempt.shape = inspect_shape(shape, model, output_.string(), progress);
        if (!attempt.shape.crossing_bodies.empty())
            find_new_crossings(attempt.shape, bodies(budget_.unlimited()), tolerance);
        attempt.output = std::make_shared<const occ::CadReference>(
            model, occ::ReferenceOptions{.foot_points = source_.options.foot_points});
        attempt.deviation =
            compare(*attempt.output, surface(), options_.samples, tolerance, progress);
        attempt.folds = folds_of(shape);
        clock.end("check");
    }

    [[nodiscard]] measure::FoldFigures folds_of(const Shape& shape) const {
        return measure::find_folds(shape.surfaces, surface(),
                                   {.tolerance_mm = options_.tolerance_mm,
                                    .creases = shape.creases,
                                    .may_face_away = !source_.figures.closed,
                                    .progress = told(budget_.unlimited())});
    }

    const Source& source_;
    std::filesystem::path output_;
    const ConvertOptions& options_;
    const base::Budget& budget_;
    std::size_t number_ = 1;  ///< of the attempt under way
    std::optional<std::vector<geom::BodyReference>> bodies_;
    std::vector<fit::PartFit> known_parts_;
};

}  // namespace

Conversion convert(const Source& source, const std::filesystem::path& output,
                   base::OutputSet& outputs, const ConvertOptions& options,
                   const base::Budget& budget) {
    // Refuses what cannot be written before the work.
    occ::file_format(output);
    const base::OutputTarget target(output);
    const double diagonal = source.surface().bounds().diagonal();
    AttemptRunner run(source, output, options, budget);
    std::vector<Attempt> attempts;
    try {
        while (const std::optional<AttemptPlan> plan = choose_next(attempts, options, diagonal)) {
            if (!attempts.empty() && budget.is_used_up()) throw base::TimeLimitReached();
            const auto make_attempt = [&] { attempts.push_back(run.carry_out(*plan, attempts)); };
            if (attempts.empty()) {
                make_attempt();
            } else {
                try {
                    if (!memory_suffices(make_attempt)) {
                        run.result.notices.push_back(fmt::format(
                            "attempt {} ran out of memory and was given up", attempts.size() + 1));
                        break;
                    }
                } catch (const base::InputError& error) {
                    // Finer blocks fold.
                    run.result.notices.push_back(fmt::format("no finer cage: {}", error.what()));
                    if (std::exchange(attempts.back().finer_refused, true)) break;
                    continue;
                }
            }
            const auto best = choose_best(attempts);
            for (std::size_t i = 0; i < attempts.size(); ++i)
                if (i != best) attempts[i].drop_file();
        }
    } catch (const base::TimeLimitReached&) {
        run.result.time_limit_reached = true;
    }
    Conversion& result = run.result;
    result.attempts = std::move(attempts);
    result.kept = choose_best(result.attempts);
    if (result.kept) {
        Attempt& best = result.attempts[*result.kept];
        const auto bound = [&] {
            add_bounds(best.deviation, *best.output, source.surface(), budget.unlimited());
        };
        if (!memory_suffices(bound))
            result.notices.emplace_back(
                "the deviation has no upper bound: finding one ran out of memory");
        outputs.add(std::exchange(best.file, nullptr));
        run.clock.end("check");
    }
    result.seconds = run.clock.seconds();
    return std::move(result);
}

Conversion convert(const Source& source, const std::filesystem::path& output,
                   const ConvertOptions& options, const base::Budget& budget) {
    base::OutputSet outputs;
    Conversion result = convert(source, output, outputs, options, budget);
    outputs.commit();
    return result;
}

Conversion fit_only(const Source& source, const ConvertOptions& options,
                    const base::Budget& budget) {
    AttemptRunner run(source, {}, options, budget);
    const double diagonal = source.surface().bounds().diagonal();
    Attempt attempt = run.fitted(*choose_next({}, options, diagonal));
    measure::VerdictFigures figures{.tolerance_mm = options.tolerance_mm,
                                    .diagonal_mm = diagonal,
                                    .stopped_by_time_limit = attempt.stopped_by_time_limit,
                                    .keeps_cage = attempt.keeps_cage};
    add_fit(figures, attempt.fit);
    if (options.refit) run.find_folds(attempt, figures);
    if (options.normal_tolerance_rad) run.find_normals(attempt, figures);
    attempt.verdict = measure::assess(figures);
    run.result.attempts.push_back(std::move(attempt));
    run.result.kept = 0;
    run.result.seconds = run.clock.seconds();
    return std::move(run.result);
}

}  // namespace patchwright::convert
