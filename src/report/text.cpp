#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::report {

namespace {

std::string full_text(const std::vector<Section>& sections) {
    std::string text;
    for (const Section& section : sections) {
        text += section.title + "\n";
        for (const auto& [label, value] : section.rows)
            text += fmt::format("  {:<16} {}\n", label, value);
    }
    return text;
}

/// One line a row; what does not fit is counted.
std::string brief_text(const std::vector<Section>& sections, std::size_t most_lines) {
    std::vector<std::string> lines;
    for (const Section& section : sections)
        for (const std::size_t i : section.brief)
            lines.push_back(fmt::format("  {:<20}{:<20}{}\n",
                                        i == section.brief.front() ? section.title : "",
                                        section.rows[i].first, section.rows[i].second));
    std::string text;
    for (std::size_t i = 0; i < std::min(lines.size(), most_lines); ++i)
        text += i + 1 == most_lines && lines.size() > most_lines
                    ? fmt::format("  and {} lines more: see --verbose\n", lines.size() - i)
                    : lines[i];
    return text;
}

}  // namespace

std::string to_text(const RunReport& report, TextDetail detail) {
    constexpr std::size_t most_lines = 15, of_verdict = 2;
    const std::string verdict =
        report.verdict ? report.verdict->sentence(report.unit) + "\n" : std::string();
    const std::vector<Section> all = sections(report);
    return verdict +
           (detail == TextDetail::Full ? full_text(all)
                                       : brief_text(all, most_lines - of_verdict)) +
           verdict;
}

}  // namespace patchwright::report
