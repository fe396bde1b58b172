#include "convert/attempt_runner.h"
#include "convert/bodies.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/occ/cad_model.h>

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

namespace patchwright::convert {

namespace {

/// A normal that agrees with the output's is looked for on the input as far off as the distance and
/// two tolerances (measure::find_folds).
constexpr double beside_tolerances = 3.0;

double size_of(const AttemptRunner& run) { return run.source().surface().size(); }

/// Of all attempts but the best one that is measured.
void drop_files(std::vector<Attempt>& attempts) {
    const auto best = choose_best(attempts, true);
    for (std::size_t i = 0; i < attempts.size(); ++i)
        if (i != best) attempts[i].drop_file();
}

/// One more attempt. @return false when one is met, none is left, or memory is used up
/// @throw TimeLimitReached when the budget is, or nothing of the attempt was completed
bool make_attempt(AttemptRunner& run, const base::Budget& budget, Conversion& conversion) {
    std::vector<Attempt>& attempts = conversion.attempts;
    const std::optional<AttemptPlan> plan = choose_next(attempts, run.options(), size_of(run));
    if (!plan) return false;
    if (!attempts.empty() && budget.is_used_up()) throw base::TimeLimitReached();
    const auto carry_out = [&] { attempts.push_back(run.carry_out(*plan, attempts)); };
    if (attempts.empty()) {
        carry_out();
    } else {
        try {
            if (!memory_suffices(carry_out)) {
                run.notice(fmt::format("attempt {} ran out of memory and was given up",
                                       attempts.size() + 1));
                return false;
            }
        } catch (const base::InputError& error) {
            // Finer blocks fold.
            run.notice(fmt::format("no finer cage: {}", error.what()));
            return !std::exchange(attempts.back().finer_refused, true);
        }
    }
    conversion.kept = choose_best(attempts);
    drop_files(attempts);
    return true;
}

/// Measures what is best by the verdicts so far; then the best one of those that are measured is
/// kept.
void measure_kept(AttemptRunner& run, Conversion& conversion) {
    std::vector<Attempt>& attempts = conversion.attempts;
    while (conversion.kept && !attempts[*conversion.kept].measured) {
        const std::size_t kept = *conversion.kept;
        const auto measure = [&] { run.measure(attempts[kept]); };
        if (attempts.size() == 1) {
            measure();
        } else if (!memory_suffices(measure)) {
            run.notice(fmt::format("attempt {} ran out of memory and was given up", kept + 1));
            attempts.erase(attempts.begin() + std::ptrdiff_t(kept));
            conversion.kept = choose_best(attempts);
        }
    }
    conversion.kept = choose_best(attempts, true);
    drop_files(attempts);
}

void make_attempts(AttemptRunner& run, const base::Budget& budget, Conversion& conversion) {
    try {
        while (make_attempt(run, budget, conversion)) continue;
    } catch (const base::TimeLimitReached&) {
        conversion.time_limit_reached = true;
    }
    measure_kept(run, conversion);
}

/// The bodies of a model, each with its attempts; nothing is written of them.
class BodyByBody {
  public:
    BodyByBody(const Source& source, const ConvertOptions& options, const base::Budget& budget,
               base::StageClock& clock)
        : options_(options), budget_(budget) {
        for (Body& body : bodies_of(source, options, budget.limited())) {
            Part& part = parts_.emplace_back();
            part.body = std::move(body);
            part.run.emplace(part.body.source, std::filesystem::path(), part.body.options, budget,
                             clock, parts_.size() - 1);
        }
        if (parts_.empty())
            throw base::InputError(
                fmt::format("{}: no body could be triangulated", source.input.file));
    }

    /// Whether no body is beside another one: then what is measured on the model is the bodies'.
    [[nodiscard]] bool are_apart() const {
        const geom::Vec3 reach = geom::Vec3::Constant(beside_tolerances * options_.tolerance_mm);
        std::vector<geom::Box3> boxes;
        for (const Part& part : parts_) {
            geom::Box3 box = part.body.source.cad->bounds();
            box.min -= reach;
            box.max += reach;
            boxes.push_back(box);
        }
        for (std::size_t i = 0; i < boxes.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if ((boxes[i].min.array() <= boxes[j].max.array()).all() &&
                    (boxes[j].min.array() <= boxes[i].max.array()).all())
                    return false;
        return true;
    }

    /// A cage of each body, fitted.
    /// @throw TimeLimitReached when there is no time to make all cages
    void fit() {
        for (Part& part : parts_)
            part.conversion.attempts.push_back(
                part.run->with_cage(*choose_next({}, part.body.options, size_of(*part.run))));
        for (Part& part : parts_) part.run->fit(part.conversion.attempts.front());
        for (Part& part : parts_) {
            part.conversion.kept = 0;
            time_limit_reached_ =
                time_limit_reached_ || part.conversion.attempts.front().stopped_by_time_limit;
        }
    }

    /// More attempts on the bodies that miss, in turn.
    void improve() {
        for (Part& part : parts_) {
            if (budget_.is_used_up()) {
                time_limit_reached_ = true;
                return;
            }
            part.run->measure(part.conversion.attempts.front());
        }
        try {
            for (bool more = true; more;) {
                more = false;
                for (Part& part : parts_)
                    more = make_attempt(*part.run, budget_, part.conversion) || more;
            }
        } catch (const base::TimeLimitReached&) {
            time_limit_reached_ = true;
        }
        for (Part& part : parts_) measure_kept(*part.run, part.conversion);
    }

    /// The best attempts on all bodies as one on the model, not measured.
    [[nodiscard]] Attempt joined() const {
        Attempt whole{.plan = best(parts_.front()).plan};
        std::vector<mesh::Cage> cages;
        std::vector<fit::FitResult> fits;
        for (const Part& part : parts_) {
            const Attempt& one = best(part);
            cages.push_back(one.cage);
            fits.push_back({.cage = one.fitted,
                            .best_level = one.fit.best_level,
                            .symmetry_axis = one.fit.symmetry_axis,
                            .stopped_by_time_limit = one.stopped_by_time_limit,
                            .levels = one.fit.levels});
            whole.kind = std::max(whole.kind, one.kind);
            whole.layout.insert(whole.layout.end(), one.layout.begin(), one.layout.end());
            auto& off = whole.fit.off_catmull_clark_mm;
            if (one.fit.off_catmull_clark_mm)
                off = std::max(off.value_or(0.0), *one.fit.off_catmull_clark_mm);
        }
        whole.folds = folds();
        whole.cage = mesh::joined(cages);
        fit::FitResult fitted = fit::joined(fits);
        whole.stopped_by_time_limit = fitted.stopped_by_time_limit;
        whole.fit.tolerance = options_.tolerance_mm;
        whole.fit.best_level = fitted.best_level;
        whole.fit.symmetry_axis = fitted.symmetry_axis;
        whole.fit.before = measure::measure_fairness(whole.cage);
        whole.fit.after = measure::measure_fairness(fitted.cage);
        whole.fit.levels = std::move(fitted.levels);
        whole.fitted = std::move(fitted.cage);
        return whole;
    }

    [[nodiscard]] BodySurfaces surfaces() const {
        BodySurfaces surfaces;
        for (const Part& part : parts_) surfaces.push_back(part.body.source.cad);
        return surfaces;
    }

    /// Hands over what was tried.
    void finish(AttemptRunner& whole, Conversion& conversion) {
        for (Part& part : parts_) {
            for (const std::string& text : part.run->notices()) whole.notice(text);
            for (Attempt& attempt : part.conversion.attempts) attempt.drop_file();
            conversion.bodies.push_back(std::move(part.conversion));
        }
        conversion.time_limit_reached = time_limit_reached_;
    }

  private:
    struct Part {
        Body body;
        std::optional<AttemptRunner> run;
        Conversion conversion;
    };

    /// The bodies' own, as normals of other ones nearby say nothing; none where a body was not
    /// measured. Faces are not numbered anew.
    [[nodiscard]] measure::FoldFigures folds() const {
        measure::FoldFigures whole;
        for (const Part& part : parts_) {
            const measure::FoldFigures& one = best(part).folds;
            if (one.samples == 0) return {};
            whole.samples += one.samples;
            whole.folded += one.folded;
            whole.by_face.insert(whole.by_face.end(), one.by_face.begin(), one.by_face.end());
            if (one.worst && (!whole.worst || one.worst->angle_rad > whole.worst->angle_rad))
                whole.worst = one.worst;
        }
        return whole;
    }

    static const Attempt& best(const Part& part) {
        return part.conversion.attempts[*part.conversion.kept];
    }

    const ConvertOptions& options_;
    const base::Budget& budget_;
    std::deque<Part> parts_;  // which their runs refer to
    bool time_limit_reached_ = false;
};

void convert_bodies(AttemptRunner& run, const base::Budget& budget, base::StageClock& clock,
                    Conversion& conversion) {
    try {
        BodyByBody bodies(run.source(), run.options(), budget, clock);
        const auto measure_all = [&] {
            Attempt whole = bodies.joined();
            run.measure(whole);
            conversion.attempts.push_back(std::move(whole));
        };
        bodies.fit();
        run.set_bodies(bodies.surfaces());
        if (bodies.are_apart()) measure_all();
        if (conversion.attempts.empty() || !conversion.attempts.front().verdict.met()) {
            bodies.improve();
            measure_all();
        }
        bodies.finish(run, conversion);
        conversion.kept = choose_best(conversion.attempts, true);
        drop_files(conversion.attempts);
    } catch (const base::TimeLimitReached&) {
        conversion.time_limit_reached = true;
    }
}

}  // namespace

Conversion convert(const Source& source, const std::filesystem::path& output,
                   base::OutputSet& outputs, const ConvertOptions& options,
                   const base::Budget& budget) {
    // Refuses what cannot be written before the work.
    occ::file_format(output);
    const base::OutputTarget target(output);
    base::StageClock clock;
    AttemptRunner run(source, output, options, budget, clock);
    Conversion result;
    if (by_bodies(source, options))
        convert_bodies(run, budget, clock, result);
    else
        make_attempts(run, budget, result);
    if (result.kept) {
        Attempt& best = result.attempts[*result.kept];
        run.find_bounds(best);
        outputs.add(std::exchange(best.file, nullptr));
    }
    result.notices = run.notices();
    result.seconds = clock.seconds();
    return result;
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
    base::StageClock clock;
    AttemptRunner run(source, {}, options, budget, clock);
    const double diagonal = size_of(run);
    Conversion result;
    Attempt attempt;
    if (by_bodies(source, options)) {
        BodyByBody bodies(source, options, budget, clock);
        bodies.fit();
        attempt = bodies.joined();
        bodies.finish(run, result);
    } else {
        attempt = run.with_cage(*choose_next({}, options, diagonal));
        run.fit(attempt);
    }
    if (options.refit) run.find_folds(attempt);
    measure::VerdictFigures figures = run.fit_figures(attempt);
    if (options.normal_tolerance_rad) run.find_normals(attempt, figures);
    attempt.verdict = measure::assess(figures);
    result.attempts.push_back(std::move(attempt));
    result.kept = 0;
    result.notices = run.notices();
    result.seconds = clock.seconds();
    return result;
}

}  // namespace patchwright::convert
