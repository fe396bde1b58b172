#include "report/plot.h"

#include <patchwright/base/markup.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace patchwright::report {

namespace {

/// A plot's frame in the SVG's units, which are pixels at full width.
constexpr double width = 640.0, height = 260.0, left = 70.0, right = 12.0, top = 26.0,
                 bottom = 44.0;

Plot convergence(const RunReport& report) {
    const double scale = 1.0 / base::millimetres_per(report.unit);
    Plot plot{.section = "Fit",
              .caption = "Convergence of the fit, level by level; dashed: the tolerance",
              .x_label = "level",
              .y_label = fmt::format("distance, {}", base::short_name(report.unit)),
              .series = {{"largest, output to input", {}},
                         {"largest, input to output", {}},
                         {"root mean square", {}}},
              .is_log = true,
              .limit = report.fit->tolerance * scale};
    for (const fit::FitLevel& level : report.fit->levels) {
        plot.x.push_back(double(plot.x.size()));
        plot.series[0].values.push_back(level.max_mm * scale);
        plot.series[1].values.push_back(level.reverse_max_mm * scale);
        plot.series[2].values.push_back(level.rms_mm * scale);
    }
    return plot;
}

/// Both ways on common bins: as wide as those of the larger deviation.
Plot histogram(const RunReport& report) {
    const double scale = 1.0 / base::millimetres_per(report.unit);
    const measure::Histogram& a = report.deviation->output_to_input.histogram;
    const measure::Histogram& b = report.deviation->input_to_output.histogram;
    const double bin = std::max(a.width, b.width);
    Plot plot{.section = "Deviation",
              .caption = "Distances: share of the area in each interval",
              .x_label = fmt::format("distance, {}", base::short_name(report.unit)),
              .y_label = "share of the area, %",
              .has_bars = true};
    for (std::size_t i = 0; i < a.shares.size(); ++i) plot.x.push_back(double(i) * bin * scale);
    for (const auto& [name, from] :
         {std::pair("output to input", &a), std::pair("input to output", &b)}) {
        Series series{name, std::vector<double>(plot.x.size(), 0.0)};
        for (std::size_t i = 0; i < from->shares.size(); ++i) {
            const double place = bin > 0.0 ? (double(i) + 0.5) * from->width / bin : 0.0;
            series.values[std::min(std::size_t(place), plot.x.size() - 1)] += 100 * from->shares[i];
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

/// Values to places in the frame.
class Axes {
  public:
    explicit Axes(const Plot& plot) : plot_(plot) {
        for (const Series& series : plot.series)
            for (const double value : series.values) add(value);
        if (plot.limit) add(*plot.limit);
        if (!(low_ <= high_)) low_ = high_ = 0.0;
        const double bin = plot.x.size() > 1 ? plot.x[1] - plot.x[0] : 1.0;
        x_end_ = plot.x.back() + (plot.has_bars ? bin : 0.0);
        if (!(x_end_ > plot.x.front())) x_end_ = plot.x.front() + 1.0;
        if (plot.is_log) {
            low_ = std::floor(low_);
            high_ = std::max(std::ceil(high_), low_ + 1.0);
        } else {
            low_ = 0.0;
            high_ = high_ > 0.0 ? 1.05 * high_ : 1.0;
        }
    }

    [[nodiscard]] double x(double value) const {
        const double t = (value - plot_.x.front()) / (x_end_ - plot_.x.front());
        return left + t * (width - left - right);
    }
    [[nodiscard]] double y(double value) const {
        const double t = plot_.is_log ? (value > 0.0 ? std::log10(value) : low_) : value;
        return height - bottom -
               std::clamp((t - low_) / (high_ - low_), 0.0, 1.0) * (height - top - bottom);
    }
    [[nodiscard]] double x_end() const { return x_end_; }

    [[nodiscard]] std::vector<double> x_ticks() const {
        if (plot_.has_bars) return even_ticks(0.0, x_end_);
        std::vector<double> ticks;
        const std::size_t step = plot_.x.size() / 12 + 1;
        for (std::size_t i = 0; i < plot_.x.size(); i += step) ticks.push_back(plot_.x[i]);
        return ticks;
    }
    [[nodiscard]] std::vector<double> y_ticks() const {
        if (!plot_.is_log) return even_ticks(low_, high_);
        std::vector<double> ticks;
        for (double power = low_; power <= high_; ++power) ticks.push_back(std::pow(10.0, power));
        return ticks;
    }

  private:
    void add(double value) {
        if (plot_.is_log && !(value > 0.0)) return;
        const double t = plot_.is_log ? std::log10(value) : value;
        low_ = std::min(low_, t);
        high_ = std::max(high_, t);
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    static std::vector<double> even_ticks(double low, double high) {
        const double power = std::pow(10.0, std::floor(std::log10((high - low) / 4.0)));
        double step = power;
        for (const double factor : {2.0, 5.0, 10.0})
            if ((high - low) / step > 6.0) step = factor * power;
        std::vector<double> ticks;
        for (int i = 0; low + i * step <= high * (1.0 + 1e-9); ++i) ticks.push_back(low + i * step);
        return ticks;
    }

    const Plot& plot_;
    double low_ = std::numeric_limits<double>::infinity(), high_ = -low_, x_end_ = 1.0;
};

std::string frame(const Plot& plot, const Axes& axes) {
    std::string text;
    const double base = height - bottom;
    for (const double tick : axes.y_ticks())
        text += fmt::format(
            "<path class=\"grid\" d=\"M{0} {1:.1f}H{2}\"/><text x=\"{3}\" y=\"{4:.1f}\" "
            "text-anchor=\"end\">{5:.3g}</text>\n",
            left, axes.y(tick), width - right, left - 6.0, axes.y(tick) + 4.0, tick);
    for (const double tick : axes.x_ticks())
        text += fmt::format(
            "<path class=\"axis\" d=\"M{0:.1f} {1}v5\"/><text x=\"{0:.1f}\" y=\"{2}\" "
            "text-anchor=\"middle\">{3:.3g}</text>\n",
            axes.x(tick), base, base + 18.0, tick);
    text += fmt::format(
        "<path class=\"axis\" d=\"M{0} {1}V{2}H{3}\"/>\n<text x=\"{4}\" y=\"{5}\" "
        "text-anchor=\"middle\">{6}</text>\n<text transform=\"translate(14 {7}) rotate(-90)\" "
        "text-anchor=\"middle\">{8}</text>\n",
        left, top, base, width - right, 0.5 * (left + width), height - 8.0,
        base::escape_markup(plot.x_label), 0.5 * (top + base), base::escape_markup(plot.y_label));
    return text;
}

std::string drawing(const Plot& plot, const Axes& axes, std::size_t number) {
    const Series& series = plot.series[number];
    std::string path;
    for (std::size_t i = 0; i < series.values.size(); ++i) {
        const double y = axes.y(series.values[i]);
        path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", axes.x(plot.x[i]), y);
        if (plot.has_bars) {
            const double end = i + 1 < plot.x.size() ? plot.x[i + 1] : axes.x_end();
            path += fmt::format("H{:.1f}", axes.x(end));
        } else {
            path += "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0 -6 0m3 0";
        }
    }
    return fmt::format("<path class=\"curve\" d=\"{}\"/>\n", path);
}

}  // namespace

std::vector<Plot> plots(const RunReport& report) {
    std::vector<Plot> all;
    if (report.fit && !report.fit->levels.empty()) all.push_back(convergence(report));
    if (report.deviation && !report.deviation->output_to_input.histogram.shares.empty() &&
        !report.deviation->input_to_output.histogram.shares.empty())
        all.push_back(histogram(report));
    return all;
}

std::string to_svg(const Plot& plot) {
    const Axes axes(plot);
    std::string text =
        fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n{}", width, height,
                    base::escape_markup(plot.caption), frame(plot, axes));
    if (plot.limit)
        text += fmt::format("<path class=\"limit\" d=\"M{} {:.1f}H{}\"/>\n", left,
                            axes.y(*plot.limit), width - right);
    double key = left + 4.0;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        const std::string& name = plot.series[i].name;
        text += fmt::format(
            "<g class=\"series{}\">{}<text class=\"key\" x=\"{}\" y=\"16\">{}</text></g>\n", i,
            drawing(plot, axes, i), key, base::escape_markup(name));
        constexpr double letter = 6.6, gap = 18.0;  // of 12 pixels
        key += letter * double(name.size()) + gap;
    }
    return text + "</svg>\n";
}

}  // namespace patchwright::report
