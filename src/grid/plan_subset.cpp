#include "grid/plan_subset.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

namespace patchwright::grid {

std::vector<int> kept_along(const BlockLayout& layout, const KeptPoints& kept, int block,
                            std::size_t side) {
    std::vector<int> all{0};
    for (const BlockEdgeUse& use : layout.blocks[std::size_t(block)].sides[side]) {
        const std::vector<int>& edge = kept[std::size_t(use.edge)];
        const int begin = all.back();
        for (std::size_t k = 1; k < edge.size(); ++k)
            all.push_back(begin +
                          (use.reversed ? edge.back() - edge[edge.size() - 1 - k] : edge[k]));
    }
    return all;
}

std::vector<int> every_second(int cells) {
    std::vector<int> kept{0};
    const auto add = [&](int count, int step) {
        for (int k = 0; k < count; ++k) kept.push_back(kept.back() + step);
    };
    const int pairs = cells / 4, rest = cells % 4;
    add(pairs, 2);
    if (rest == 2)
        add(1, 2);
    else
        add(rest, 1);
    add(pairs, 2);
    return kept;
}

KeptPoints every_second(const Plan& plan) {
    KeptPoints kept;
    for (const EdgePoints& edge : plan.edges) kept.push_back(every_second(edge.cells()));
    return kept;
}

std::vector<Between> between(const std::vector<int>& kept) {
    std::vector<Between> result;
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
        for (int n = kept[k]; n < kept[k + 1]; ++n)
            result.push_back({int(k), double(n - kept[k]) / (kept[k + 1] - kept[k])});
    result.push_back({int(kept.size()) - 2, 1.0});
    return result;
}

Plan subset(const Plan& plan, const KeptPoints& kept) {
    Plan result{plan.layout, {}, {}};
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
        const EdgePoints& fine = plan.edges[e];
        EdgePoints edge;
        edge.length_mm = fine.length_mm;
        edge.points.resize(Eigen::Index(kept[e].size()), 3);
        for (std::size_t k = 0; k < kept[e].size(); ++k) {
            edge.parameters.push_back(fine.parameters[std::size_t(kept[e][k])]);
            edge.points.row(Eigen::Index(k)) = fine.points.row(kept[e][k]);
        }
        result.edges.push_back(std::move(edge));
    }
    for (std::size_t b = 0; b < plan.moved.size(); ++b) {
        const auto width = std::size_t(plan.size(int(b))[0]);
        std::vector<subd::Location> places;
        for (const int j : kept_along(plan.layout, kept, int(b), 1))
            for (const int i : kept_along(plan.layout, kept, int(b), 0))
                places.push_back(plan.moved[b][std::size_t(i) + width * std::size_t(j)]);
        result.moved.push_back(std::move(places));
    }
    return result;
}

Plan coarsened(const Plan& plan, int levels) {
    if (levels < 0 || levels > 16) {
        throw base::InvalidArgument(fmt::format("{} levels; use 0 to 16", levels));
    }
    const int step = 1 << levels;
    KeptPoints kept(plan.edges.size());
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
        const int cells = plan.edges[e].cells();
        if (cells % step != 0) {
            throw base::UsageError(
                fmt::format("block edge {} has {} cells, no multiple of {}; make the grid with "
                            "more levels",
                            e, cells, step));
        }
        for (int k = 0; k <= cells; k += step) kept[e].push_back(k);
    }
    return subset(plan, kept);
}

}  // namespace patchwright::grid
