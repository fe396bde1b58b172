// Deviations as they stand in JSON reports.
#pragma once

#include <patchwright/report/run_report.h>

#include <nlohmann/json.hpp>

namespace patchwright::report {

using Json = nlohmann::ordered_json;

/// Both ways.
/// @param scale  of the report's unit, 1/mm
Json deviation_json(const DeviationFigures& figures, double scale);

Json fairness_json(const measure::RelativeFairness& figures, double scale);

/// Between sharp curves.
Json sharp_curves_json(const DeviationFigures& figures, double scale);

}  // namespace patchwright::report
