// What reports and verdicts say of whole files and attempts, whoever asks for them.
#pragma once

#include <patchwright/convert/convert.h>

#pragma GCC visibility push(default)
namespace patchwright::convert {

/// Of one model as the output of another: distances, long sharp curves, and what it is by itself.
measure::Verdict assess(const Source& output, const Source& input,
                        const report::DeviationFigures& deviation, double tolerance_mm,
                        std::optional<double> normal_tolerance_rad = std::nullopt);

/// What a closer look at a model finds.
/// @throw Cancelled or TimeLimitReached from the progress callback
report::DetailFigures inspect_closely(const Source& source, const base::Progress& progress = {});

/// Puts what an attempt reached into a report.
void add_attempt(report::RunReport& report, const Attempt& attempt);

/// The same of one that was fitted only.
void add_fitted(report::RunReport& report, const Attempt& attempt);

}  // namespace patchwright::convert
#pragma GCC visibility pop
