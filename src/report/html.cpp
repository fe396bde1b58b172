#include "report/figures.h"

#include <patchwright/base/markup.h>
#include <patchwright/base/version.h>

#include <fmt/format.h>

namespace patchwright::report {

namespace {

constexpr std::string_view style =
    "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;width:100%}td{padding:.25em .8em .25em 0;vertical-align:top;"
    "border-top:1px solid #ddd}td:first-child{width:12em;color:#555}h1{font-size:1.5em}"
    "h2{font-size:1.1em;margin:1.4em 0 .3em}li{margin:.2em 0}";

}  // namespace

std::string to_html(const RunReport& report) {
    std::string page = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>patchwright "
        "report</title><style>{}</style></head>\n<body><h1>patchwright {}</h1>\n",
        style, base::version());
    if (report.verdict)
        page += fmt::format("<p><strong>{}</strong></p>\n",
                            base::escape_markup(report.verdict->sentence(report.unit)));
    for (const Section& section : sections(report)) {
        page += fmt::format("<h2>{}</h2>\n<table>\n", base::escape_markup(section.title));
        for (const auto& [label, value] : section.rows) {
            page += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", base::escape_markup(label),
                                base::escape_markup(value));
        }
        page += "</table>\n";
    }
    if (!report.notices.empty()) {
        page += "<h2>Notices</h2>\n<ul>\n";
        for (const std::string& notice : report.notices) {
            page += fmt::format("<li>{}</li>\n", base::escape_markup(notice));
        }
        page += "</ul>\n";
    }
    return page + "</body></html>\n";
}

}  // namespace patchwright::report
