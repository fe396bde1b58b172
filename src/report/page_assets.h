// What is built from src/report/page: see decision 059.
#pragma once

#include <string_view>

namespace patchwright::report {

/// The page's style sheet.
std::string_view page_style();

/// The program of the page's 3-D view and plots; empty where it could not be bundled.
std::string_view page_script();

}  // namespace patchwright::report
