#include "measure/pair_search.h"
#include "measure/surface_crossing.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/self_intersection.h>

#include <algorithm>

namespace patchwright::measure {

namespace {

/// Tests of pairs beside those for each pair of spans: three times what the sheets of a thin wing
/// take. Most make a piece, of half a kilobyte.
constexpr std::size_t base_tests = 3'000'000;
/// Looked into at a time, as their pieces take memory.
constexpr std::size_t group = 64;

PairSearch::Surfaces pieces_of(const geom::BsplineSurface* surfaces, std::size_t count,
                               double resolution) {
    PairSearch::Surfaces pieces(count);
    base::parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
            pieces[k] = std::make_unique<SurfacePieces>(surfaces[k], resolution);
    });
    return pieces;
}

std::vector<PairTask> loop_tasks(const PairSearch::Surfaces& surfaces) {
    std::vector<std::vector<SurfacePieces::Pair>> pairs(surfaces.size());
    base::parallel_for(surfaces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) pairs[k] = surfaces[k]->candidates();
    });
    std::vector<PairTask> tasks;
    for (std::size_t k = 0; k < surfaces.size(); ++k)
        for (const auto& pair : pairs[k]) tasks.push_back({{int(k), int(k)}, pair});
    return tasks;
}

}  // namespace

std::vector<SelfIntersection> find_self_intersections(
    const std::vector<geom::BsplineSurface>& surfaces, double resolution_mm,
    const base::Progress& progress) {
    if (!(resolution_mm > 0.0))
        throw base::InvalidArgument("find_self_intersections: the resolution must be positive");
    std::size_t tests_left = base_tests;
    std::vector<SelfIntersection> result;
    const auto run = [&](const PairSearch::Surfaces& pieces, std::vector<PairTask> tasks,
                         std::size_t start, const char* stage) {
        PairSearch search(pieces, std::move(tasks), resolution_mm);
        const double done = double(start) / double(surfaces.size());
        for (auto& [numbers, hit] :
             search.run(tests_left, [&] { base::report_progress(progress, stage, done); })) {
            result.push_back(hit);
            for (int& number : result.back().surfaces) number += int(start);
        }
    };
    for (std::size_t start = 0; start < surfaces.size(); start += group) {
        const auto pieces =
            pieces_of(&surfaces[start], std::min(group, surfaces.size() - start), resolution_mm);
        run(pieces, loop_tasks(pieces), start, "self-intersection");
    }
    const auto pieces = pieces_of(surfaces.data(), surfaces.size(), resolution_mm);
    run(pieces, crossing_tasks(pieces), 0, "crossings");
    return result;
}

}  // namespace patchwright::measure
