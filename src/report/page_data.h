// What the page's program (src/report/page/page.js) draws, as JSON.
#pragma once

#include "report/plot.h"

#include <patchwright/report/run_report.h>

#include <string>
#include <vector>

namespace patchwright::report {

/// A place worth a look.
struct Place {
    geom::Vec3 at = geom::Vec3::Zero();
    std::string text;
};

/// What the verdict misses, then the largest deviations both ways.
std::vector<Place> places(const RunReport& report);

/// Fits into a script element. Of models of more vertices than make two of them 3 MB, only a part
/// is shown, of cages that 16 bits do not number, nothing.
std::string page_data(const RunReport& report, const std::vector<Plot>& plots);

/// Bytes as a URL or a script has them.
std::string base64(const void* bytes, std::size_t count);

}  // namespace patchwright::report
