// The figures of a report as titled lists of (label, value), which text and HTML lay out.
#pragma once

#include <patchwright/report/run_report.h>

#include <string>
#include <utility>
#include <vector>

namespace patchwright::report {

struct Section {
    std::string title;
    std::vector<std::pair<std::string, std::string>> rows;
    std::vector<std::size_t> brief;  ///< rows that are told even where there is little space
};

std::vector<Section> sections(const RunReport& report);

}  // namespace patchwright::report
