#include "convert/attempt_runner.h"

#include "convert/body_contacts.h"
#include "convert/earlier_state.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/measure/crease_rule.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

namespace patchwright::convert {

namespace {

/// Of the tolerance, for caps at extraordinary vertices and for what lies between the fit's
/// samples; the rest is for the fit.
constexpr double caps_share = 0.05;
/// Of made cages, between levels that gain something: all faces are split once.
constexpr double made_idle_growth = 4.0;
/// How far a fit grows (FitOptions): a made cage that is too coarse by more is better made anew.
struct Growth {
    int levels = 12, vertices = 200000;
    double idle_growth = made_idle_growth, idle_share = 1.0;
};

/// What a level of four times the faces may leave of the distance where the cage has sizes that the
/// shape asks for: splits of smooth regions leave a quarter and less.
constexpr double most_left = 0.6;
/// Vertices of blocks: some to begin with, and as many a face as if all were split twice. What they
/// lack are single strips, and several levels of these are fewer vertices (decision 105).
constexpr int first_vertices = 2000, vertices_a_face = 16;
/// More vertices than this are not a few clean patches any more.
constexpr int most_vertices = 40000;
/// Remeshed cages' faces are all split.
constexpr int remeshed_levels = 2;

/// Of a remeshed cage's faces: where fewer are to be split, another cage with shorter edges around
/// them has fewer faces than all of them split, which are four times as many.
constexpr double few_faces = 0.1;

/// Whether the faces of such cages have the size that the shape asks for.
bool has_sizes_of_shape(CageKind kind) {
    return kind == CageKind::Field || kind == CageKind::Blocks || kind == CageKind::Remeshed;
}
/// Their lines lie where they are to stay, but not evenly: those of coarser cages have their way to
/// go (FitOptions::Solver::tangential_scale_rel, decision 087).
constexpr double sized_tangential_scale_rel = 0.3;

Growth growth_of(CageKind kind, int faces) {
    Growth growth;
    switch (kind) {
        case CageKind::Given: growth.idle_growth = std::numeric_limits<double>::infinity(); break;
        case CageKind::Sections: break;
        case CageKind::Field:
        case CageKind::Blocks:
            growth.vertices = std::min(most_vertices, first_vertices + vertices_a_face * faces);
            growth.idle_share = most_left;
            break;
        case CageKind::Remeshed:
            growth.levels = remeshed_levels;
            growth.vertices = most_vertices;
            growth.idle_share = most_left;
            break;
    }
    return growth;
}

std::optional<double> off_catmull_clark(const mesh::Cage& cage) {
    if (!cage.topology->has_runouts()) return std::nullopt;
    return measure::distance_from_catmull_clark(cage);
}

}  // namespace

bool memory_suffices(const std::function<void()>& work) {
    const base::MayRunOutOfMemory scope;
    try {
        work();
        return true;
    } catch (const std::bad_alloc&) {
        return false;
    }
}

Attempt AttemptRunner::with_cage(const AttemptPlan& plan, const std::vector<Attempt>& attempts) {
    Attempt attempt{.plan = plan};
    number_ = attempts.size() + 1;
    make_cage(attempt, attempts);
    clock_.end("layout");
    return attempt;
}

void AttemptRunner::make_cage(Attempt& attempt, const std::vector<Attempt>& attempts) {
    const AttemptPlan& plan = attempt.plan;
    if (plan.given) {
        attempt.cage = *options_.cage;
        return;
    }
    if (!attempts.empty() && attempts.back().plan.same_cage(plan)) {
        attempt.kind = attempts.back().kind;
        attempt.cage = attempts.back().cage;
        attempt.layout = attempts.back().layout;
        attempt.finer_refused = attempts.back().finer_refused;
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

void AttemptRunner::fit(Attempt& attempt) {
    const Growth growth = growth_of(attempt.kind, attempt.cage.topology->face_count());
    fit::FitOptions fitting{
        .tolerance_mm = (1.0 - caps_share) * attempt.plan.fit_share * options_.tolerance_mm,
        .refinement =
            attempt.kind == CageKind::Remeshed ? fit::RefinementScope::Global : options_.refinement,
        .max_levels = options_.max_levels.value_or(growth.levels),
        .max_vertices = growth.vertices,
        .max_idle_growth = growth.idle_growth,
        .idle_share = growth.idle_share,
        .preserve_parametrisation = attempt.plan.preserve_parametrisation,
        .symmetry = options_.symmetry,
        .crease_rule = options_.crease_rule,
        .interpolate = options_.interpolate,
        .progress = told(budget_.limited())};
    // Recognised shapes gather lines on purpose (decision 090).
    fitting.solver.evens_lines = attempt.kind != CageKind::Sections;
    if (has_sizes_of_shape(attempt.kind))
        fitting.solver.tangential_scale_rel = sized_tangential_scale_rel;
    if (attempt.kind == CageKind::Remeshed && options_.refinement == fit::RefinementScope::Local)
        fitting.min_share_to_split_all = few_faces;
    fit::FitResult found = fitted(attempt, fitting);
    if (found.faces_away)
        notice(
            "the cage faces the other way than the model; it was fitted so, and so does the "
            "result (reverse the order of the vertices of its faces to turn it)");
    attempt.stopped_by_time_limit = found.stopped_by_time_limit;
    attempt.keeps_cage = options_.refit;
    attempt.fit = {.carried = std::move(attempt.fit.carried),
                   .tolerance = options_.tolerance_mm,
                   .best_level = found.best_level,
                   .symmetry_axis = found.symmetry_axis,
                   .off_catmull_clark_mm = off_catmull_clark(found.cage),
                   .before = measure::measure_fairness(attempt.cage),
                   .after = measure::measure_fairness(found.cage),
                   .levels = std::move(found.levels)};
    attempt.misses = std::move(found.misses);
    attempt.fitted = std::move(found.cage);
    attempt.verdict = measure::assess(fit_figures(attempt));
    clock_.end("fit");
}

measure::VerdictFigures AttemptRunner::fit_figures(const Attempt& attempt) const {
    measure::VerdictFigures figures{.tolerance_mm = options_.tolerance_mm,
                                    .diagonal_mm = source_.input.diagonal,
                                    .stopped_by_time_limit = attempt.stopped_by_time_limit,
                                    .keeps_cage = attempt.keeps_cage};
    add_fit(figures, attempt.fit);
    if (attempt.folds.samples > 0) add_folds(figures, attempt.folds);
    return figures;
}

fit::FitResult AttemptRunner::fitted(Attempt& attempt, const fit::FitOptions& fitting) const {
    if (options_.refit) return refitted(attempt, fitting);
    try {
        return fit::fit(attempt.cage, surface(), fitting);
    } catch (const base::TimeLimitReached&) {
        if (!body_) throw;
        fit::FitResult given = fit::measure_given(attempt.cage, surface(), fitting);
        given.stopped_by_time_limit = true;
        return given;
    }
}

fit::FitResult AttemptRunner::refitted(Attempt& attempt, const fit::FitOptions& fitting) const {
    check_earlier_state(attempt.cage, source_);
    std::optional<fit::ModelChange> change;
    if (const Source* earlier = options_.earlier) {
        check_fitted_to(attempt.cage, *earlier, source_);
        change.emplace(fit::ModelState{earlier->surface(), earlier->input.file},
                       fit::ModelState{surface(), source_.input.file});
    }
    fit::RefitResult carried = fit::refit(attempt.cage, surface(),
                                          {.fit = fitting, .change = change ? &*change : nullptr});
    attempt.fit.carried = std::move(carried.stages);
    return std::move(carried.fit);
}

void AttemptRunner::measure(Attempt& attempt) {
    const base::Progress progress = told(budget_.unlimited());
    const double tolerance = options_.tolerance_mm;
    const Shape shape = make_shape(attempt.fitted, options_.shape, shape_tolerance(), &surface());
    for (const std::string& text : shape.notices) notice(text);
    clock_.end("patch");
    std::optional<occ::CadModel> written;
    if (!output_.empty()) {
        attempt.file = std::make_shared<base::PendingFile>(output_);
        occ::WriteOptions writing = options_.shape.write;
        if (!writing.name) writing.name = output_.stem().string();
        written = write_and_read_back(shape, *attempt.file, writing);
        clock_.end("write");
    }
    const occ::CadModel& model = written ? *written : shape.model;
    attempt.patches = shape.patches;
    attempt.shape = inspect_shape(shape, model, output_.string(), progress);
    if (!attempt.shape.crossing_bodies.empty())
        find_new_crossings(attempt.shape, bodies(), tolerance);
    attempt.output = std::make_shared<const occ::CadReference>(
        model, occ::ReferenceOptions{.foot_points = source_.options.foot_points});
    attempt.deviation = compare(*attempt.output, surface(), options_.samples, tolerance, progress);
    if (attempt.folds.samples == 0) attempt.folds = folds_of(shape);
    if (body_) attempt.drop_file();  // nobody looks at a body by itself
    clock_.end("check");
    attempt.measured = true;
    attempt.verdict =
        assess(attempt, source_, options_.tolerance_mm, options_.normal_tolerance_rad);
}

Attempt AttemptRunner::carry_out(const AttemptPlan& plan, const std::vector<Attempt>& attempts) {
    Attempt attempt = with_cage(plan, attempts);
    fit(attempt);
    // What takes longest is done last, for what may still be met.
    if (attempt.verdict.met()) find_folds(attempt);
    if (attempt.verdict.met()) measure(attempt);
    return attempt;
}

void AttemptRunner::find_bounds(Attempt& best) {
    const auto bound = [&] {
        add_bounds(best.deviation, *best.output, surface(), budget_.unlimited());
    };
    if (!memory_suffices(bound))
        notice("the deviation has no upper bound: finding one ran out of memory");
    clock_.end("check");
}

void AttemptRunner::find_folds(Attempt& attempt) {
    attempt.folds = folds_of(make_shape(attempt.fitted, options_.shape, shape_tolerance()));
    attempt.verdict = measure::assess(fit_figures(attempt));
    clock_.end("check");
}

void AttemptRunner::find_normals(const Attempt& attempt, measure::VerdictFigures& figures) {
    const Shape shape = make_shape(attempt.fitted, options_.shape, shape_tolerance());
    add_normals(
        figures,
        measure::measure_relative_fairness(
            occ::CadReference(shape.model), surface(),
            {.samples = options_.samples, .lines = 0, .progress = told(budget_.unlimited())}));
    figures.normal_tolerance_rad = options_.normal_tolerance_rad;
    clock_.end("check");
}

void AttemptRunner::notice(std::string text) {
    if (std::find(notices_.begin(), notices_.end(), text) == notices_.end())
        notices_.push_back(std::move(text));
}

ShapeTolerance AttemptRunner::shape_tolerance() const {
    return {caps_share * options_.tolerance_mm, options_.tolerance_mm};
}

/// The number of the body, and from the second attempt on its number, go before the stage.
base::Progress AttemptRunner::told(base::Progress progress) const {
    std::string before;
    if (body_) before += fmt::format("body {}, ", *body_ + 1);
    if (number_ > 1) before += fmt::format("attempt {}, ", number_);
    if (before.empty() || !progress) return progress;
    return [progress = std::move(progress), before](std::string_view stage, double fraction) {
        return progress(fmt::format("{}{}", before, stage), fraction);
    };
}

measure::FoldFigures AttemptRunner::folds_of(const Shape& shape) const {
    return measure::find_folds(shape.surfaces, surface(),
                               {.tolerance_mm = options_.tolerance_mm,
                                .creases = shape.creases,
                                .may_face_away = !source_.figures.closed,
                                .progress = told(budget_.unlimited())});
}

const BodySurfaces& AttemptRunner::bodies() {
    if (bodies_) return *bodies_;
    bodies_.emplace();
    // Bodies of triangles are not told apart.
    if (source_.model)
        for (const occ::BodyReference& body : occ::body_references(
                 *source_.model, source_.reference_options(told(budget_.unlimited()))))
            bodies_->push_back(body.surface);
    return *bodies_;
}

}  // namespace patchwright::convert
