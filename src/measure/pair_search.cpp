#include "measure/pair_search.h"

#include "measure/surface_crossing.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <mutex>
#include <utility>

namespace patchwright::measure {

namespace {

using Next = SurfacePieces::Next;

/// For each pair of spans: ten times what slender sectors take.
constexpr std::size_t tests_per_pair = 300;
/// Tests between two calls of the progress callback, and by one thread at a time.
constexpr std::size_t block = 1 << 14, grain = 64;

}  // namespace

PairSearch::Found PairSearch::run(std::size_t& tests_left,
                                  const std::function<void()>& check_progress) {
    tests_left += tests_per_pair * tasks_.size();
    while (!tasks_.empty() && tasks_.size() <= tests_left) {
        tests_left -= tasks_.size();
        test_all(check_progress);
        halve();
    }
    for (const PairTask& task : tasks_)
        if (!found_.contains(task.surfaces)) found_.emplace(task.surfaces, doubt_at(task));
    return std::move(found_);
}

SurfacePieces::Outcome PairSearch::test(const PairTask& task) const {
    const auto [s, t] = task.surfaces;
    const SurfacePieces &first = *surfaces_[std::size_t(s)], &second = *surfaces_[std::size_t(t)];
    return s == t ? first.test(task.pieces)
                  : test_crossing(first, second, task.pieces, resolution_);
}

void PairSearch::test_all(const std::function<void()>& check_progress) {
    next_.assign(tasks_.size(), Next::Nothing);
    std::vector<std::pair<std::size_t, SelfIntersection>> hits;  // with numbers of tasks
    std::mutex mutex;
    const auto test_some = [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const auto outcome = test(tasks_[k]);
            next_[k] = outcome.next;
            if (!outcome.hit) continue;
            const std::lock_guard lock(mutex);
            hits.emplace_back(k, *outcome.hit);
        }
    };
    for (std::size_t start = 0; start < tasks_.size(); start += block) {
        check_progress();
        base::parallel_for(
            std::min(block, tasks_.size() - start), grain,
            [&](std::size_t begin, std::size_t end) { test_some(start + begin, start + end); });
    }
    // The first task's, whichever thread is faster.
    std::sort(hits.begin(), hits.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [task, hit] : hits) {
        hit.surfaces = tasks_[task].surfaces;
        found_.try_emplace(hit.surfaces, hit);
    }
}

void PairSearch::halve() {
    std::vector<std::vector<int>> wanted(surfaces_.size());
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
        const PairTask& task = tasks_[k];
        if (next_[k] != Next::Nothing && found_.contains(task.surfaces)) next_[k] = Next::Nothing;
        if (next_[k] == Next::Nothing) continue;
        const std::size_t side = next_[k] == Next::HalveFirst ? 0 : 1;
        wanted[std::size_t(task.surfaces[side])].push_back(task.pieces[side]);
    }
    for (std::size_t s = 0; s < surfaces_.size(); ++s) surfaces_[s]->halve(wanted[s]);
    std::vector<PairTask> tasks;
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
        if (next_[k] == Next::Nothing) continue;
        const auto& [surfaces, pieces] = tasks_[k];
        const std::size_t side = next_[k] == Next::HalveFirst ? 0 : 1;
        const int low = surfaces_[std::size_t(surfaces[side])]->half(pieces[side]), high = low + 1;
        if (surfaces[0] == surfaces[1] && pieces[0] == pieces[1]) {
            for (const auto& part : {SurfacePieces::Pair{low, low}, {high, high}, {low, high}})
                tasks.push_back({surfaces, part});
            continue;
        }
        for (const int half : {low, high}) {
            tasks.push_back({surfaces, pieces});
            tasks.back().pieces[side] = half;
        }
    }
    tasks_ = std::move(tasks);
}

/// In the middle of the first piece.
SelfIntersection PairSearch::doubt_at(const PairTask& task) const {
    SelfIntersection doubt{.surfaces = task.surfaces, .is_found = false};
    for (std::size_t k = 0; k < 2; ++k) {
        const BezierPiece& piece = surfaces_[std::size_t(task.surfaces[k])]->piece(task.pieces[k]);
        doubt.uv[k] = {0.5 * (piece.u[0] + piece.u[1]), 0.5 * (piece.v[0] + piece.v[1])};
        if (k == 0) doubt.point = piece.at(0.5, 0.5).position;
    }
    return doubt;
}

}  // namespace patchwright::measure
