// Carries out attempts: a cage, its fit, patches, figures.
#pragma once

#include "convert/body_contacts.h"

#include <patchwright/base/stage_clock.h>
#include <patchwright/convert/convert.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace patchwright::convert {

/// For work without which there is a result. @return false when it ran out of memory
bool memory_suffices(const std::function<void()>& work);

/// What the attempts on a model, or on one of its bodies, share.
class AttemptRunner {
  public:
    /// All outlive this.
    /// @param output  empty: nothing is written
    /// @param body    number of the body from 0, for progress
    AttemptRunner(const Source& source, const std::filesystem::path& output,
                  const ConvertOptions& options, const base::Budget& budget,
                  base::StageClock& clock, std::optional<std::size_t> body = std::nullopt)
        : source_(source),
          output_(output),
          options_(options),
          budget_(budget),
          clock_(clock),
          body_(body) {}

    /// The plan's cage, or that of the last attempt if it is the same.
    /// @throw TimeLimitReached when there is no time to make one
    /// @throw InputError when there is none
    Attempt with_cage(const AttemptPlan& plan, const std::vector<Attempt>& attempts = {});
    /// With the verdict on its own samples.
    /// @throw TimeLimitReached when no level of the fit was completed; not of bodies, whose cage is
    ///        then measured as it is
    void fit(Attempt& attempt);
    /// Patches, the file, figures and the verdict.
    void measure(Attempt& attempt);
    /// All of it; nothing is measured where the fit misses or its patches fold.
    /// @throw TimeLimitReached, InputError
    Attempt carry_out(const AttemptPlan& plan, const std::vector<Attempt>& attempts);
    /// The bounds of the best attempt's deviation, unless memory is used up.
    void find_bounds(Attempt& best);

    /// Of the fit by itself, with folds where they were looked for.
    [[nodiscard]] measure::VerdictFigures fit_figures(const Attempt& attempt) const;
    /// Of the patches of what was fitted, for the verdict on the fit.
    void find_folds(Attempt& attempt);
    /// Of the same patches.
    void find_normals(const Attempt& attempt, measure::VerdictFigures& figures);

    /// The model's bodies, where they are known; else they are found when needed.
    void set_bodies(BodySurfaces bodies) { bodies_ = std::move(bodies); }

    /// One line each, for the user, without repetitions.
    [[nodiscard]] const std::vector<std::string>& notices() const { return notices_; }
    void notice(std::string text);
    [[nodiscard]] const Source& source() const { return source_; }
    [[nodiscard]] const ConvertOptions& options() const { return options_; }

  private:
    [[nodiscard]] const geom::ModelSurface& surface() const { return source_.surface(); }
    [[nodiscard]] ShapeTolerance shape_tolerance() const;
    void make_cage(Attempt& attempt, const std::vector<Attempt>& attempts);
    [[nodiscard]] base::Progress told(base::Progress progress) const;
    [[nodiscard]] fit::FitResult refitted(Attempt& attempt, const fit::FitOptions& fitting) const;
    [[nodiscard]] fit::FitResult fitted(Attempt& attempt, const fit::FitOptions& fitting) const;
    [[nodiscard]] measure::FoldFigures folds_of(const Shape& shape) const;
    const BodySurfaces& bodies();

    const Source& source_;
    std::filesystem::path output_;
    const ConvertOptions& options_;
    const base::Budget& budget_;
    base::StageClock& clock_;
    std::optional<std::size_t> body_;
    std::size_t number_ = 1;  ///< of the attempt under way
    std::optional<BodySurfaces> bodies_;
    std::vector<std::string> notices_;
};

}  // namespace patchwright::convert
