#include "measure/surface_crossing.h"

#include "geom/bvh.h"
#include "measure/corner_fans.h"

#include <patchwright/base/parallel.h>

#include <algorithm>

namespace patchwright::measure {

namespace {

/// Pieces of one thread at once.
constexpr std::size_t pieces_a_task = 64;

}  // namespace

std::vector<PairTask> crossing_tasks(const PairSearch::Surfaces& surfaces) {
    struct Span {
        int surface, number;
    };
    std::vector<Span> spans;
    std::vector<geom::Box3> boxes;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        for (int k = 0; k < surfaces[s]->span_count(); ++k) {
            spans.push_back({int(s), k});
            boxes.push_back(surfaces[s]->piece(k).box);
        }
    }
    if (boxes.empty()) return {};
    const geom::Bvh tree(boxes);
    const CornerFans fans(surfaces);
    std::vector<std::vector<int>> near(spans.size());
    base::parallel_for(spans.size(), pieces_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const geom::Box3& box = boxes[k];
            tree.nearest(box.centre(), 0.5 * box.diagonal(), [&](int other, double bound) {
                const geom::Box3& b = boxes[std::size_t(other)];
                const Span &here = spans[k], &there = spans[std::size_t(other)];
                if (there.surface > here.surface && (box.min.array() <= b.max.array()).all() &&
                    (b.min.array() <= box.max.array()).all() &&
                    !fans.share_fan(here.surface, here.number, there.surface, there.number))
                    near[k].push_back(other);
                return bound;
            });
            std::sort(near[k].begin(), near[k].end());
        }
    });
    std::vector<PairTask> tasks;
    for (std::size_t k = 0; k < spans.size(); ++k) {
        for (const int other : near[k]) {
            const Span &a = spans[k], &b = spans[std::size_t(other)];
            tasks.push_back({{a.surface, b.surface}, {a.number, b.number}});
        }
    }
    return tasks;
}

SurfacePieces::Outcome test_crossing(const SurfacePieces& first, const SurfacePieces& second,
                                     const SurfacePieces::Pair& pair, double resolution) {
    using Next = SurfacePieces::Next;
    constexpr double exact = 1e-6;  // of the resolution: how near two points are that count as one
    const BezierPiece &a = first.piece(pair[0]), &b = second.piece(pair[1]);
    if ((a.box.min.array() > b.box.max.array()).any() ||
        (b.box.min.array() > a.box.max.array()).any() || are_apart(a, b, resolution))
        return {};
    const auto met = meeting_point(a, b, exact * resolution);
    if (met && !(is_beside_side(first.surface(), met->point, met->uv[0], resolution) &&
                 is_beside_side(second.surface(), met->point, met->uv[1], resolution)))
        return {Next::Nothing, SelfIntersection{{}, met->point, met->uv}};
    if (a.size() <= resolution && b.size() <= resolution) return {};
    return {a.size() >= b.size() ? Next::HalveFirst : Next::HalveSecond, {}};
}

}  // namespace patchwright::measure
