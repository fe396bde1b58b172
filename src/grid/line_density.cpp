#include "grid/line_density.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/evaluate.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::grid {

namespace {

constexpr int bin_count = 256;
constexpr int samples_a_face = 8;

/// Wishes of the chords of one line, by the middle's share of the line's length.
void add_line(const std::vector<geom::Vec3>& points, bool reversed, const SizeFunction& size,
              LineDensity& density) {
    std::vector<double> length{0.0};
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        length.push_back(length.back() + (points[k + 1] - points[k]).norm());
    }
    const double total = length.back();
    if (total <= 0.0) return;
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const geom::Vec3 middle = 0.5 * (points[k] + points[k + 1]);
        const double h = size(middle);
        if (!(h > 0.0) || !std::isfinite(h)) {
            throw base::InvalidArgument(
                fmt::format("the size function returns {} at ({}, {}, {}); it must be positive", h,
                            middle.x(), middle.y(), middle.z()));
        }
        const auto bin = [&](double s) {
            return std::clamp(int((reversed ? 1.0 - s : s) * bin_count), 0, bin_count - 1);
        };
        const int a = bin(length[k] / total), b = bin(length[k + 1] / total);
        for (int n = std::min(a, b); n <= std::max(a, b); ++n) {
            double& wish = density.bins[std::size_t(n)];
            wish = std::max(wish, total / h);
        }
    }
}

}  // namespace

double LineDensity::before(double fraction, bool reversed) const {
    const double x = std::clamp(fraction, 0.0, 1.0) * double(bins.size());
    double sum = 0.0;
    for (std::size_t k = 0; k < bins.size() && x > double(k); ++k) {
        sum += bins[reversed ? bins.size() - 1 - k : k] * std::min(1.0, x - double(k));
    }
    return sum / double(bins.size());
}

double LineDensity::fraction(double cells, bool reversed) const {
    double left = cells * double(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k) {
        const double here = bins[reversed ? bins.size() - 1 - k : k];
        if (left <= here) return (double(k) + left / here) / double(bins.size());
        left -= here;
    }
    return 1.0;
}

std::vector<LineDensity> line_densities(const BlockLayout& layout, const LineClasses& classes,
                                        const SizeFunction& size) {
    std::vector<LineDensity> densities(std::size_t(classes.count()),
                                       {std::vector<double>(bin_count, 0.0)});
    // A grid that is fine enough to look at: a few points a face.
    Plan sampling{layout, {}};
    std::size_t longest = 1;
    for (const BlockEdge& edge : layout.edges) longest = std::max(longest, edge.run.size());
    PlanOptions options;
    options.cells = std::max(32, samples_a_face * int(longest));
    sampling = make_plan(layout, options);
    const BlockEvaluator evaluator(sampling);
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        const BlockPoints points = evaluator.evaluate(int(b));
        for (const bool along_i : {true, false}) {
            const auto& uses = layout.blocks[b].sides[along_i ? 0 : 1];
            const int lines = along_i ? points.nj : points.ni;
            const int on_line = along_i ? points.ni : points.nj;
            const int step = std::max(1, (lines - 1) / 32);
            for (int line = 0; line < lines; line += step) {
                // Sides of several edges: each has its own part of the line and its own class.
                int begin = 0;
                for (const BlockEdgeUse& use : uses) {
                    const int cells = sampling.edges[std::size_t(use.edge)].cells();
                    std::vector<geom::Vec3> part;
                    for (int k = begin; k <= begin + cells && k < on_line; ++k) {
                        part.push_back(along_i ? points.at(k, line) : points.at(line, k));
                    }
                    const LineClasses::Member& member = classes.edges[std::size_t(use.edge)];
                    add_line(part, member.reversed != use.reversed, size,
                             densities[std::size_t(member.line_class)]);
                    begin += cells;
                }
            }
        }
    }
    for (std::size_t c = 0; c < densities.size(); ++c) {
        auto& bins = densities[c].bins;
        if (classes.mirrored[c] == 0) continue;
        for (std::size_t k = 0; k < bins.size() / 2; ++k) {
            bins[k] = bins[bins.size() - 1 - k] = std::max(bins[k], bins[bins.size() - 1 - k]);
        }
    }
    return densities;
}

}  // namespace patchwright::grid
