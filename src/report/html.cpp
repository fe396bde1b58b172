#include "report/figures.h"
#include "report/page_assets.h"
#include "report/page_data.h"
#include "report/plot.h"

#include <patchwright/base/markup.h>
#include <patchwright/base/version.h>
#include <patchwright/report/picture.h>

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

namespace patchwright::report {

namespace {

using base::escape_markup;

std::string table(const Section& section) {
    std::string text = fmt::format("<h2>{}</h2>\n<table>\n", escape_markup(section.title));
    for (const auto& [label, value] : section.rows)
        text += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escape_markup(label),
                            escape_markup(value));
    return text + "</table>\n";
}

/// The drawing is replaced by the page's program where that runs.
std::string figure(const Plot& plot, std::size_t number) {
    return fmt::format(
        "<figure class=\"plot\" data-plot=\"{}\">{}<figcaption>{}</figcaption></figure>\n", number,
        to_svg(plot), escape_markup(plot.caption));
}

std::string picture(const std::string& png, const std::string& caption, const char* attributes) {
    return fmt::format(
        "<figure{2}><img alt=\"{0}\" src=\"data:image/png;base64,{1}\">"
        "<figcaption>{0}</figcaption></figure>\n",
        escape_markup(caption), base64(png.data(), png.size()), attributes);
}

/// A picture, which the page's program replaces by the 3-D view, and the places to look at.
std::string view(const RunReport& report) {
    const Scene& scene = *report.scene;
    const measure::Field* field = scene.output ? &*scene.output : nullptr;
    if (field == nullptr) return {};
    const std::string png = to_png(*field, {.scale_mm = scene.scale_mm, .is_transparent = true});
    const std::string caption =
        field->distance_mm.empty()
            ? "The model and its faces"
            : fmt::format(
                  "The output and its patches, coloured by the distance from the input: "
                  "blue 0, red {:.3g} {} or more",
                  scene.scale_mm / base::millimetres_per(report.unit),
                  base::short_name(report.unit));
    std::string text = picture(png, caption, " id=\"view\"");
    const std::vector<Place> all = places(report);
    if (all.empty()) return text;
    text += "<h2>Places to look at</h2>\n<ol class=\"places\">\n";
    for (const Place& place : all) text += fmt::format("<li>{}</li>\n", escape_markup(place.text));
    return text + "</ol>\n";
}

std::string file_of(const RunReport& report, std::string_view option) {
    for (const auto& [name, value] : report.options)
        if (name == option) return std::filesystem::path(value).filename().string();
    return {};
}

/// What was done to which files, as the names of their folders tell nothing here.
std::string title_of(const RunReport& report) {
    if (report.options.empty()) return "patchwright report";
    std::string text = report.options.front().second;
    const std::size_t only_command = text.size();
    for (const char* option : {"input", "file", "a", "b"})
        if (const std::string file = file_of(report, option); !file.empty()) text += " " + file;
    if (text.size() == only_command) text += " " + file_of(report, "cage");
    const std::string output = file_of(report, "output");
    return output.empty() ? text : text + " \u2192 " + output;
}

std::string head(const RunReport& report) {
    const std::string title = escape_markup(title_of(report));
    std::string text = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta "
        "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>{0}</title>\n<style>{1}</style></head>\n<body>\n<h1>{0}</h1>\n",
        title, page_style());
    if (report.verdict)
        text += fmt::format("<p class=\"verdict {}\">{}</p>\n",
                            report.verdict->met() ? "met" : "missed",
                            escape_markup(report.verdict->sentence(report.unit)));
    return text;
}

std::string program(const RunReport& report, const std::vector<Plot>& all_plots) {
    if (page_script().empty() || (!report.scene && all_plots.empty())) return {};
    return fmt::format(
        "<script type=\"application/json\" id=\"data\">{}</script>\n<script>{}</script>\n",
        page_data(report, all_plots), page_script());
}

}  // namespace

std::string to_html(const RunReport& report) {
    const std::vector<Plot> all_plots = plots(report);
    std::string page = head(report);
    if (report.scene) page += view(report);
    if (report.drawing) page += picture(report.drawing->png, report.drawing->caption, "");
    for (const Section& section : sections(report)) {
        page += table(section);
        for (std::size_t i = 0; i < all_plots.size(); ++i)
            if (all_plots[i].section == section.title) page += figure(all_plots[i], i);
    }
    if (!report.notices.empty()) {
        page += "<h2>Notices</h2>\n<ul>\n";
        for (const std::string& notice : report.notices)
            page += fmt::format("<li>{}</li>\n", escape_markup(notice));
        page += "</ul>\n";
    }
    if (!report.options.empty()) page += table({"Options", report.options, {}});
    page += fmt::format("<p class=\"by\">patchwright {}</p>\n", base::version());
    return page + program(report, all_plots) + "</body></html>\n";
}

}  // namespace patchwright::report
