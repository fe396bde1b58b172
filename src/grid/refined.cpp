#include "grid/edge_curve.h"
#include "grid/line_classes.h"
#include "grid/memory.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/evaluate.h>

#include <fmt/format.h>

namespace patchwright::grid {

namespace {

/// Per edge and cell, in the edge's direction, whether the cell is halved.
using Marks = std::vector<std::vector<char>>;

/// The plan with the marked cells halved by parameters; old points keep their bits.
Plan halved(const Plan& plan, const Marks& marks) {
    const subd::LimitEvaluator limit(plan.layout.cage.topology);
    Plan fine{plan.layout, std::vector<EdgePoints>(plan.edges.size())};
    base::parallel_for(plan.edges.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t e = first; e < last; ++e) {
            const EdgeCurve curve(limit, plan.layout.cage, plan.layout.edges[e]);
            const EdgePoints& old = plan.edges[e];
            EdgePoints& edge = fine.edges[e];
            edge.length_mm = old.length_mm;
            std::vector<geom::Vec3> points;
            for (std::size_t k = 0; k < old.parameters.size(); ++k) {
                edge.parameters.push_back(old.parameters[k]);
                points.push_back(old.points.row(Eigen::Index(k)).transpose());
                if (k + 1 == old.parameters.size() || marks[e][k] == 0) continue;
                const double middle = 0.5 * (old.parameters[k] + old.parameters[k + 1]);
                edge.parameters.push_back(middle);
                points.push_back(curve.at(middle));
            }
            edge.points.resize(Eigen::Index(points.size()), 3);
            for (std::size_t k = 0; k < points.size(); ++k) {
                edge.points.row(Eigen::Index(k)) = points[k];
            }
        }
    });
    return fine;
}

/// Which cells of a block's lines along i or j have too large an error; `points` has each cell
/// halved.
std::vector<char> bad_cells(const BlockPoints& points, bool along_i, const LineError& error,
                            double limit) {
    const int lines = along_i ? points.nj : points.ni;
    const int cells = ((along_i ? points.ni : points.nj) - 1) / 2;
    std::vector<char> bad(std::size_t(cells), 0);
    const auto at = [&](int k, int line) {
        return along_i ? points.at(k, line) : points.at(line, k);
    };
    constexpr std::size_t cells_a_task = 64;
    base::parallel_for(bad.size(), cells_a_task, [&](std::size_t first, std::size_t last) {
        for (int line = 0; line < lines; line += 2) {
            for (std::size_t n = first; n < last; ++n) {
                if (bad[n] != 0) continue;
                const int k = int(n);
                if (error(at(2 * k, line), at(2 * k + 2, line), at(2 * k + 1, line)) > limit) {
                    bad[n] = 1;
                }
            }
        }
    });
    return bad;
}

}  // namespace

Plan refined(const Plan& plan, const LineError& error, double limit, const RefineOptions& options) {
    if (!(limit > 0.0)) {
        throw base::InvalidArgument(
            fmt::format("the error's limit is {}; it must be positive", limit));
    }
    if (!plan.moved.empty())
        throw base::InvalidArgument("a smoothed plan cannot be refined; smooth it afterwards");
    const LineClasses classes = line_classes(plan.layout);
    Plan result = plan;
    for (int round = 0; round < options.max_rounds; ++round) {
        Marks all(result.edges.size());
        Marks by_class(std::size_t(classes.count()));
        for (std::size_t e = 0; e < all.size(); ++e) {
            all[e].assign(std::size_t(result.edges[e].cells()), 1);
            by_class[std::size_t(classes.edges[e].line_class)].assign(all[e].size(), 0);
        }
        const Plan probe = halved(result, all);
        require_memory(probe, 1, 0);
        const BlockEvaluator evaluator(probe);
        BlockPoints points;
        for (std::size_t b = 0; b < result.layout.blocks.size(); ++b) {
            evaluator.evaluate(int(b), points);
            for (const bool along_i : {true, false}) {
                base::report_progress(options.progress, "grid", double(round) / options.max_rounds);
                const std::vector<char> bad = bad_cells(points, along_i, error, limit);
                std::size_t begin = 0;
                for (const BlockEdgeUse& use : result.layout.blocks[b].sides[along_i ? 0 : 1]) {
                    const auto& member = classes.edges[std::size_t(use.edge)];
                    auto& marks = by_class[std::size_t(member.line_class)];
                    const std::size_t n = marks.size();
                    for (std::size_t k = 0; k < n; ++k) {
                        if (bad[begin + k] == 0) continue;
                        const bool reversed = member.reversed != use.reversed;
                        marks[reversed ? n - 1 - k : k] = 1;
                        if (classes.mirrored[std::size_t(member.line_class)] != 0) {
                            marks[reversed ? k : n - 1 - k] = 1;
                        }
                    }
                    begin += n;
                }
            }
        }
        bool any = false;
        Marks marks(result.edges.size());
        for (std::size_t e = 0; e < marks.size(); ++e) {
            const auto& member = classes.edges[e];
            marks[e] = by_class[std::size_t(member.line_class)];
            if (member.reversed) std::reverse(marks[e].begin(), marks[e].end());
            for (const char mark : marks[e]) any = any || mark != 0;
        }
        if (!any) break;
        result = halved(result, marks);
    }
    return result;
}

}  // namespace patchwright::grid
