// Plots of a report: as SVG for pages without a program and for print, as data for those with one.
#pragma once

#include <patchwright/report/run_report.h>

#include <optional>
#include <string>
#include <vector>

namespace patchwright::report {

struct Series {
    std::string name;
    std::vector<double> values;  ///< one an x
};

struct Plot {
    std::string section;  ///< whose figures it belongs to; see Section::title
    std::string caption, x_label, y_label;
    std::vector<double> x;
    std::vector<Series> series;
    bool is_log = false;          ///< y by powers of ten
    bool has_bars = false;        ///< values hold from one x to the next
    std::optional<double> limit;  ///< a line across
};

/// Those that the report has figures for: convergence of the fit, histogram of the deviation.
std::vector<Plot> plots(const RunReport& report);

std::string to_svg(const Plot& plot);

}  // namespace patchwright::report
